"""The errors a user may meet; each message names what is wrong and what to do about it."""


class GlassWorkbenchError(Exception):
    """Something failed; the message is one sentence that a user can act on (exit code 1)."""


class InputError(GlassWorkbenchError):
    """What the user gave cannot be used: names the file or field, the fault and the remedy (exit code 2)."""


class Cancelled(GlassWorkbenchError):
    """The user stopped the work before it was done (exit code 1)."""


class OutOfTimeError(GlassWorkbenchError):
    """The computation was given too little time; with more it may succeed."""
