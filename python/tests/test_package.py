"""What is tested is the wheel, and it is typed and documented."""

import inspect
import pathlib
import re
import sys

import courier
from conftest import tried


def test_it_is_the_installed_wheel(command):
    folder = pathlib.Path(courier.__file__).parent
    assert folder.is_relative_to(sys.prefix)
    assert (folder / "py.typed").exists()
    assert (folder / "_native.pyi").exists()
    assert [file.name for file in folder.glob("_native.*so")] == ["_native.abi3.so"], "one wheel for every interpreter"
    assert command.says("--version").splitlines()[0] == f"courier {courier.__version__}"


def test_everything_public_is_documented():
    for name in courier.__all__:
        one = getattr(courier, name)
        assert one.__doc__ and not one.__doc__.startswith(f"{name}("), name


# Options of the command that a function has under another name, or in another way.
OTHERWISE = {
    "--json": "to_json()",
    "--help": "help()",
    "--model": "the answer's model",
    "--report": "report",
    "--out": "diagnose_many; to_json()",
    "--force": "nothing is written",
    "--jobs": "diagnose_many",
    "--form": "the answer's constants",
    "--column": "columns",
    "--pitch": "pitch_m",
    "--travel": "travel_pitches",
}


def test_every_option_of_the_commands_is_there(command):
    for name in ("diagnose", "check", "replay", "isolability", "encoder"):
        options = set(re.findall(r"^ +(?:-\w, )?(--[\w-]+)", command.says(name, "--help"), re.MULTILINE))
        # Which board: of commands that need one.
        options -= set(re.findall(r"--(?:sim|probe|emulated|chip)[\w-]*", " ".join(options)))
        here = {"--" + argument.replace("_", "-") for argument in inspect.signature(getattr(courier, name)).parameters}
        assert "--json" in options
        assert options - here - set(OTHERWISE) == set(), name


def functions_of(one):
    """The functions of a class that are written down in the package, or the function itself."""
    functions = [one] if inspect.isfunction(one) else filter(inspect.isfunction, vars(one).values())
    folder = str(pathlib.Path(courier.__file__).parent)
    return [function for function in functions if function.__code__.co_filename.startswith(folder)]


def test_everything_public_is_annotated():
    seen = 0
    for function in (function for name in courier.__all__ for function in functions_of(getattr(courier, name))):
        arguments = [argument for argument in inspect.signature(function).parameters if argument != "self"]
        missing = {*arguments, "return"} - set(function.__annotations__)
        assert not missing, f"{function.__qualname__}: {missing}"
        seen += 1
    assert seen > len(courier.__all__) // 3, "few functions were looked at"


def test_the_page_says_what_comes(page):
    examples, failed, _ = page
    assert examples > 20 and failed == 0


def test_the_packages_own_example():
    examples, failed, _ = tried(courier.__file__)
    assert examples > 1 and failed == 0
