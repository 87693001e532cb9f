"""Synonyms of actions for the command palette, and reasons why actions are unavailable.

Screens may give more precise reasons with `GaitScreen.obstacle`.
"""

from typing import NamedTuple


class Search(NamedTuple):
    """Search data of an action.

    Attributes:
        words: synonyms, separated by spaces.
        why: reason why it is unavailable and how to enable it, unless its screen gives one.
        title: name of the action on other screens; '' hides it there.
        where: how to reach the action from other screens.
    """

    words: str = ""
    why: str = ""
    title: str = ""
    where: str = ""


_PRODUCTS = (
    "make video movie film mp4 gif plot figure picture png pdf svg matlab mat csv servo robot gait "
    "arduino dynamixel feetech ros ros2 bag hardware calibration file save analyse analysis "
    "imitate imitation network curve"
)
_REASONS = "score terms analyse analysis gait name explain breakdown"
_EXPORT = "On a run at home, live or in a replay: press e."
_SHOWN = "No champion is shown yet: it is loading, or the run has none."
_CHAMPION = "The run has no champion yet; let it evolve."

SEARCH: dict[str, Search] = {
    "home.open": Search("watch attach live steer continue resume show enter"),
    "home.mark": Search("select choose several tick"),
    "home.sort": Search("order by column"),
    "home.turn": Search("reverse order descending ascending"),
    "home.new": Search(
        "start begin create evolve preset experiment body",
        title="New run",
        where="At home: press n.",
    ),
    "home.replay": Search(
        "champion play animation motion side beside", title="Replay", where="At home: press r."
    ),
    "home.compare": Search(
        "differences curves overlay several versus statistics",
        title="Compare",
        where="At home: mark two or more runs with space, then press c.",
    ),
    "home.export": Search(_PRODUCTS, title="Export", where=_EXPORT),
    "home.why": Search(
        _REASONS, title="Why", where="On a run at home, live or in a replay: press w."
    ),
    "home.map": Search(
        "archive atlas heat map elites members cells coverage quality diversity",
        title="Map",
        where="On a run with an archive, at home, live or in a replay: press M.",
    ),
    "home.gallery": Search(
        "site browser web html page share show publish", title="Gallery", where="At home: press B."
    ),
    "home.filter": Search("search find words", title="Filter", where="At home: press /."),
    "home.delete": Search("remove erase trash several", title="Delete", where="At home: press d."),
    "home.stop": Search("end halt kill background", title="Stop", where="At home: press x."),
    "home.note": Search("comment annotate remark text", title="Note", where="At home: press N."),
    "home.rename": Search("name move folder call", title="Rename", where="At home: press R."),
    "home.laboratory": Search(
        "damage lost leg remove broken adapt trial error recover",
        title="Laboratory",
        where="On a run of a body with legs, at home, live or in a replay: press L.",
    ),
    "home.files": Search(
        "exports made open pictures videos plots", title="Files", where="At home: press f."
    ),
    "home.plugins": Search(
        "bodies body fitness operators packages", title="Plugins", where="At home: press p."
    ),
    "live.pause": Search(
        "wait halt hold", "The run is not evolving here.", "Pause", "On a live run: press space."
    ),
    "live.go": Search(
        "continue start run evolve attach",
        "The run is already evolving, or finished; press g to plan more generations.",
    ),
    "live.step": Search("one generation", "The run is finished; press g to plan more generations."),
    "live.stop": Search("end quit save halt", "The run is not evolving here."),
    "live.change": Search(
        "set option parameter rate mutation weight fitness selection crossover stage steer",
        "Another process evolves the run, or it is still preparing.",
        "Change",
        "On a live run: press c.",
    ),
    "live.fork": Search(
        "copy branch clone duplicate",
        "The run has no finished generation to copy.",
        "Fork",
        "On a live run: press f.",
    ),
    "live.replay": Search("champion play animation motion", _CHAMPION),
    "live.goal": Search(
        "generations target length more further extend",
        "Another process evolves the run, or it is still preparing.",
        "Goal",
        "On a live run: press g.",
    ),
    "live.why": Search(_REASONS, _CHAMPION),
    "live.export": Search(_PRODUCTS, _CHAMPION),
    "live.laboratory": Search("damage lost leg remove broken adapt", _CHAMPION),
    "live.map": Search("archive atlas heat elites cells coverage", "The search keeps no archive."),
    "live.log": Search("history messages terms what happened"),
    "replay.play": Search("start go animation", f"The motion is already playing, or: {_SHOWN}"),
    "replay.pause": Search(
        "stop hold halt animation", f"The motion is already paused, or: {_SHOWN}"
    ),
    "replay.frame-back": Search("step previous", _SHOWN),
    "replay.frame-on": Search("step next", _SHOWN),
    "replay.generation-back": Search("previous earlier", _SHOWN),
    "replay.generation-on": Search("next later", _SHOWN),
    "replay.go-to": Search("generation number jump", _SHOWN, "Go to", "In a replay: press g."),
    "replay.best": Search("champion", _SHOWN),
    "replay.slower": Search(
        "speed slow motion rate time", _SHOWN, "Slower", "In a replay: press <."
    ),
    "replay.faster": Search("speed rate time", _SHOWN, "Faster", "In a replay: press >."),
    "replay.view": Search("camera side above front angle perspective", _SHOWN),
    "replay.follow": Search("camera track", _SHOWN),
    "replay.closer": Search("zoom in larger", _SHOWN, "Closer", "In a replay: press +."),
    "replay.farther": Search("zoom out smaller", _SHOWN),
    "replay.reset": Search("camera zoom", _SHOWN),
    "replay.measures": Search("terms score numbers values panel curve", _SHOWN),
    "replay.split": Search(
        "beside two compare second", title="Split", where="In a replay: press s."
    ),
    "replay.why": Search(_REASONS, _SHOWN),
    "replay.export": Search(_PRODUCTS, _SHOWN),
    "replay.code": Search(
        "challenge share copy clipboard verify score", _SHOWN, "Code", "In a replay: press C."
    ),
    "replay.laboratory": Search("damage lost leg remove broken adapt", _SHOWN),
    "steering.restart": Search("again start fly"),
    "steering.view": Search("camera behind side above"),
    "lab.adapt": Search("search trial error recover map gaussian bayesian"),
    "lab.stop": Search("cancel end"),
    "lab.joint": Search("stuck weak slow damage"),
    "lab.repair": Search("intact reset undo heal"),
    "lab.physics": Search("twin rigid body mujoco simulation"),
    "lab.replay": Search("play animation motion"),
    "lab.export": Search(_PRODUCTS),
    "replay.map": Search("archive atlas heat elites cells", "The search keeps no archive."),
    "map.axes-back": Search("pair legs previous"),
    "map.axes-on": Search("pair legs next"),
    "map.across": Search("axis horizontal x"),
    "map.upwards": Search("axis vertical y"),
    "map.best": Search("champion elite"),
    "map.go-to": Search("member number jump"),
    "map.replay": Search("play animation motion frame"),
    "map.why": Search(_REASONS),
    "map.export": Search(_PRODUCTS),
    "map.laboratory": Search("damage lost leg remove broken adapt"),
    "map.play": Search("pause stop go animation"),
    "map.view": Search("camera side above front angle perspective"),
    "compare.quantity": Search(
        "median mean diversity best axis", "None of these runs has a generation yet."
    ),
    "compare.by": Search(
        "axis time seconds evaluations", "None of these runs has a generation yet."
    ),
    "compare.replay": Search("champion play motion", "The chosen run has no champion yet."),
    "compare.statistics": Search(
        "repeats test significance interval effect size compare experiments",
        "This needs two or more runs.",
        "Statistics",
        "On the comparison screen: press s.",
    ),
    "screen.studies": Search("sweep compare statistics repeats operators table surface report"),
    "screen.verify": Search(
        "reproduce check identical bits checksum",
        "No run with a finished generation is selected.",
        "Verify",
        "On a run at home or live: press v.",
    ),
    "studies.new": Search("sweep begin start create"),
    "studies.compare": Search("statistics test begin start create"),
    "studies.continue": Search("resume go", "Only a stopped study can be continued."),
    "studies.stop": Search("end kill", "It is not running in this app."),
    "verify.some": Search("sample again", "It is still running."),
    "verify.all": Search("whole run", "It is still running."),
    "verify.stop": Search("end kill", "It has ended."),
    "results.files": Search("figure surface report table open"),
    "results.copy": Search("clipboard", "Select a file first; press f to go to the files."),
    "curves.zoom-in": Search("closer larger"),
    "curves.zoom-out": Search("farther smaller"),
    "curves.all": Search("reset zoom whole"),
    "curves.log": Search("logarithmic scale axis"),
    "curves.log-below": Search("logarithmic generation axis x"),
    "curves.smooth": Search("average median noise filter"),
    "new.run": Search("start begin evolve go"),
    "new.search": Search("find option parameter filter rate"),
    "new.save": Search("write toml experiment export"),
    "new.load": Search("open toml experiment import"),
    "new.reset": Search("undo default discard"),
    "plugins.check": Search("test conformance contract verify"),
    "plugins.new": Search("start begin create", "Select a body or a preset that can be loaded."),
    "plugins.filter": Search("search find words"),
    "tasks.copy": Search("clipboard file", "The task has written no file."),
    "tasks.stop": Search("end cancel kill", "It has ended."),
    "tasks.again": Search("repeat retry", "It is still running."),
    "tasks.clear": Search("forget remove", "No task has ended."),
    "files.open": Search("show view", "This run has no exports yet; press e to export files."),
    "files.copy": Search("clipboard", "This run has no exports yet; press e to export files."),
    "files.make": Search(_PRODUCTS),
    "app.help": Search("keys shortcuts manual"),
    "app.quit": Search("exit leave close end"),
    "app.jump": Search("focus go widget"),
    "app.copy": Search("clipboard shell terminal cli line script", "This screen has no command."),
    "app.tasks": Search(
        "background jobs progress video", "No tasks yet; press e on a run to export files."
    ),
}
