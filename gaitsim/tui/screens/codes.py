"""Challenge codes: one of an individual is shown, and a pasted one is checked."""

from gaitsim.errors import GaitsimError
from gaitsim.individual import Individual
from gaitsim.sharing.challenge import Challenge, code_of
from gaitsim.tui.screens.base import GaitScreen
from gaitsim.tui.screens.questions import AskText

LONGEST = 100_000  # maximum number of characters in a command's argument


def read_code(text: str) -> str:
    """Return the challenge code in a text, on one line.

    Raises:
        GaitsimError: the text holds no valid code, or the code is too long.
    """
    code = Challenge.read(text).code
    if len(code) > LONGEST:
        raise GaitsimError(
            f"the code has {len(code):,} characters",
            allowed=f"at most {LONGEST:,} in this dialog",
            remedy="save it to a file and run: gaitsim verify FILE",
        )
    return code


async def show_code(screen: GaitScreen, individual: Individual) -> None:
    """Copy the challenge code of an individual, and show it in a dialog."""
    try:
        code = await screen.in_thread(code_of, individual)
    except GaitsimError as error:
        screen.gaitsim.show_error(error)
        return
    screen.app.copy_to_clipboard(code)
    title = f"{individual.title}: copied a challenge code of {len(code):,} characters"
    about = "Anyone can play it: gaitsim verify CODE"
    if await screen.app.push_screen_wait(AskText(title, code, "Copy", about=about)):
        screen.app.copy_to_clipboard(code)
