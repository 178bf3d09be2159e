"""What the user chose last, kept in FreeCAD's parameters."""

from __future__ import annotations

import os

import FreeCAD

from glassworkbench.settings import USER_GLASSES

_GROUP = "User parameter:BaseApp/Preferences/Mod/GlassWorkbench"


def text(name: str, default: str) -> str:
    """Return a remembered text."""
    return FreeCAD.ParamGet(_GROUP).GetString(name, default)


def remember_text(name: str, value: str) -> None:
    """Keep a text for the next time."""
    FreeCAD.ParamGet(_GROUP).SetString(name, value)


def use_glass_folder() -> None:
    """Let the catalogue look into the folder of glasses that the user set (GlassFolder), if there is one."""
    folder = text("GlassFolder", "")
    if folder:
        os.environ.setdefault(USER_GLASSES, folder)


def number(name: str, default: float) -> float:
    """Return a remembered number."""
    return FreeCAD.ParamGet(_GROUP).GetFloat(name, default)


def remember_number(name: str, value: float) -> None:
    """Keep a number for the next time."""
    FreeCAD.ParamGet(_GROUP).SetFloat(name, value)
