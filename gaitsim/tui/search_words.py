"""Synonyms of actions for the command palette, and reasons why actions are unavailable.

`GaitScreen.obstacle` returns more precise reasons on some screens.
"""

from typing import NamedTuple


class Hints(NamedTuple):
    """Texts of an action in the palette, besides its description.

    Attributes:
        words: synonyms, separated by spaces.
        why: reason why it is unavailable, and how to enable it; a screen may override it.
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
_EXPORT = "At home, on a live run or in a replay: press e."
_SHOWN = "No champion is shown yet: it is loading, or the run has none."
_CHAMPION = "The run has no champion yet; let it evolve."

SEARCH: dict[str, Hints] = {
    "home.open": Hints("watch attach live steer continue resume show enter"),
    "home.mark": Hints("select choose several tick"),
    "home.sort": Hints("order by column"),
    "home.turn": Hints("reverse order descending ascending"),
    "home.new": Hints(
        "start begin create evolve preset experiment body",
        title="New run",
        where="At home: press n.",
    ),
    "home.replay": Hints(
        "champion play animation motion side beside", title="Replay", where="At home: press r."
    ),
    "home.compare": Hints(
        "differences curves overlay several versus statistics",
        title="Compare",
        where="At home: mark two or more runs with space, then press c.",
    ),
    "home.export": Hints(_PRODUCTS, title="Export", where=_EXPORT),
    "home.why": Hints(
        _REASONS, title="Why", where="At home, on a live run or in a replay: press w."
    ),
    "home.map": Hints(
        "archive atlas heat map elites members cells coverage quality diversity",
        title="Map",
        where="At home, on a live run or in a replay, for a run with an archive: press M.",
    ),
    "home.gallery": Hints(
        "site browser web html page share show publish", title="Gallery", where="At home: press B."
    ),
    "home.filter": Hints("search find words", title="Filter", where="At home: press /."),
    "home.delete": Hints("remove erase trash several", title="Delete", where="At home: press d."),
    "home.stop": Hints("end halt kill background", title="Stop", where="At home: press x."),
    "home.note": Hints("comment annotate remark text", title="Note", where="At home: press N."),
    "home.rename": Hints("name move folder call", title="Rename", where="At home: press R."),
    "home.laboratory": Hints(
        "damage lost leg remove broken adapt trial error recover",
        title="Laboratory",
        where="At home, on a live run or in a replay, for a body with legs: press L.",
    ),
    "home.files": Hints(
        "exports made open pictures videos plots", title="Files", where="At home: press f."
    ),
    "home.plugins": Hints(
        "bodies body fitness operators packages", title="Plugins", where="At home: press p."
    ),
    "live.pause": Hints(
        "wait halt hold", "The run is not evolving here.", "Pause", "On a live run: press space."
    ),
    "live.go": Hints(
        "continue start run evolve attach",
        "The run is already evolving, or finished; press g to plan more generations.",
    ),
    "live.step": Hints("one generation", "The run is finished; press g to plan more generations."),
    "live.stop": Hints("end quit save halt", "The run is not evolving here."),
    "live.change": Hints(
        "set option parameter rate mutation weight fitness selection crossover stage steer",
        "Another process evolves the run, or the run is still being prepared.",
        "Change",
        "On a live run: press c.",
    ),
    "live.fork": Hints(
        "copy branch clone duplicate",
        "The run has no finished generation to copy.",
        "Fork",
        "On a live run: press f.",
    ),
    "live.replay": Hints("champion play animation motion", _CHAMPION),
    "live.goal": Hints(
        "goal target length more further extend",
        "Another process evolves the run, or the run is still being prepared.",
        "Generations",
        "On a live run: press g.",
    ),
    "live.why": Hints(_REASONS, _CHAMPION),
    "live.export": Hints(_PRODUCTS, _CHAMPION),
    "live.laboratory": Hints("damage lost leg remove broken adapt", _CHAMPION),
    "live.map": Hints("archive atlas heat elites cells coverage", "The search keeps no archive."),
    "live.log": Hints("history messages terms what happened"),
    "replay.play": Hints(
        "start go animation", "The motion is already playing, or none is shown yet."
    ),
    "replay.pause": Hints(
        "stop hold halt animation", "The motion is already paused, or none is shown yet."
    ),
    "replay.frame-back": Hints("step previous", _SHOWN),
    "replay.frame-on": Hints("step next", _SHOWN),
    "replay.generation-back": Hints("previous earlier", _SHOWN),
    "replay.generation-on": Hints("next later", _SHOWN),
    "replay.go-to": Hints("generation number jump", _SHOWN, "Go to", "In a replay: press g."),
    "replay.best": Hints("champion", _SHOWN),
    "replay.slower": Hints(
        "speed slow motion rate time", _SHOWN, "Slower", "In a replay: press <."
    ),
    "replay.faster": Hints("speed rate time", _SHOWN, "Faster", "In a replay: press >."),
    "replay.view": Hints("camera side above front angle perspective", _SHOWN),
    "replay.follow": Hints("camera track", _SHOWN),
    "replay.closer": Hints("zoom in larger", _SHOWN, "Closer", "In a replay: press +."),
    "replay.farther": Hints("zoom out smaller", _SHOWN),
    "replay.reset": Hints("camera zoom", _SHOWN),
    "replay.measures": Hints("terms score numbers values panel curve", _SHOWN),
    "replay.split": Hints(
        "beside two compare second", title="Split", where="In a replay: press s."
    ),
    "replay.why": Hints(_REASONS, _SHOWN),
    "replay.export": Hints(_PRODUCTS, _SHOWN),
    "replay.code": Hints(
        "challenge share copy clipboard verify score", _SHOWN, "Code", "In a replay: press C."
    ),
    "replay.laboratory": Hints("damage lost leg remove broken adapt", _SHOWN),
    "steering.restart": Hints("again start fly"),
    "steering.view": Hints("camera behind side above"),
    "lab.adapt": Hints("search trial error recover map gaussian bayesian"),
    "lab.stop": Hints("cancel end"),
    "lab.joint": Hints("stuck weak slow damage"),
    "lab.repair": Hints("intact reset undo heal"),
    "lab.physics": Hints("twin rigid body mujoco simulation"),
    "lab.replay": Hints("play animation motion"),
    "lab.export": Hints(_PRODUCTS),
    "replay.map": Hints("archive atlas heat elites cells", "The search keeps no archive."),
    "map.axes-back": Hints("pair legs previous"),
    "map.axes-on": Hints("pair legs next"),
    "map.across": Hints("axis horizontal x"),
    "map.upwards": Hints("axis vertical y"),
    "map.best": Hints("champion elite"),
    "map.go-to": Hints("member number jump"),
    "map.replay": Hints("play animation motion frame"),
    "map.why": Hints(_REASONS),
    "map.export": Hints(_PRODUCTS),
    "map.laboratory": Hints("damage lost leg remove broken adapt"),
    "map.play": Hints("pause stop go animation"),
    "map.view": Hints("camera side above front angle perspective"),
    "compare.quantity": Hints(
        "median mean diversity best axis", "None of these runs has a finished generation yet."
    ),
    "compare.by": Hints(
        "axis time seconds evaluations", "None of these runs has a finished generation yet."
    ),
    "compare.replay": Hints("champion play motion", "The chosen run has no champion yet."),
    "compare.statistics": Hints(
        "repeats test significance interval effect size compare experiments",
        "Statistics need two or more runs.",
        "Statistics",
        "On the comparison screen: press s.",
    ),
    "screen.studies": Hints("sweep compare statistics repeats operators table surface report"),
    "screen.verify": Hints(
        "reproduce check identical bits checksum",
        "No run with a finished generation is selected.",
        "Verify",
        "On a run at home or live: press v.",
    ),
    "studies.new": Hints("sweep begin start create"),
    "studies.compare": Hints("statistics test begin start create"),
    "studies.continue": Hints("resume go", "Only a stopped study can be continued."),
    "studies.stop": Hints("end kill", "The study is not running in this app."),
    "verify.some": Hints("sample again", "The verification is still running."),
    "verify.all": Hints("whole run", "The verification is still running."),
    "verify.stop": Hints("end kill", "The verification has ended."),
    "results.files": Hints("figure surface report table open"),
    "results.copy": Hints("clipboard", "Select a file first; press f to go to the files."),
    "curves.zoom-in": Hints("closer larger"),
    "curves.zoom-out": Hints("farther smaller"),
    "curves.all": Hints("reset zoom whole"),
    "curves.log": Hints("logarithmic scale axis"),
    "curves.log-below": Hints("logarithmic generation axis x"),
    "curves.smooth": Hints("average median noise filter"),
    "new.run": Hints("start begin evolve go"),
    "new.search": Hints("find option parameter filter rate"),
    "new.save": Hints("write toml experiment export"),
    "new.load": Hints("open toml experiment import"),
    "new.reset": Hints("undo default discard"),
    "plugins.check": Hints("test conformance contract verify"),
    "plugins.new": Hints("start begin create", "Select a body or a preset that can be loaded."),
    "plugins.filter": Hints("search find words"),
    "tasks.copy": Hints("clipboard file", "The task has not written a file."),
    "tasks.stop": Hints("end cancel kill", "The task has ended."),
    "tasks.again": Hints("repeat retry", "The task is still running."),
    "tasks.clear": Hints("forget remove", "No task has ended."),
    "files.open": Hints("show view", "This run has no exports yet; press e to export files."),
    "files.copy": Hints("clipboard", "This run has no exports yet; press e to export files."),
    "files.make": Hints(_PRODUCTS),
    "app.help": Hints("keys shortcuts manual"),
    "app.quit": Hints("exit leave close end"),
    "app.jump": Hints("focus go widget"),
    "app.copy": Hints("clipboard shell terminal cli line script", "This screen has no command."),
    "app.tasks": Hints(
        "background jobs progress video",
        "There are no tasks yet; press e on a run to export files.",
    ),
}
