#!/usr/bin/env -S uv run --script
# /// script
# dependencies = ["nox>=2025.2.9"]
# ///
"""Tasks in environments of their own: `nox -s lint`, `tests`, `wheel`. `./run all` does all of it in one."""

import nox

nox.needs_version = ">=2025.2.9"
nox.options.default_venv_backend = "uv|virtualenv"


@nox.session
def lint(session: nox.Session) -> None:
    """Formatting and lint, without the core."""
    session.install("ruff==0.17.5")
    session.run("ruff", "check", ".")
    session.run("ruff", "format", "--check", ".")


@nox.session(python=["3.11", "3.12", "3.13", "3.14"], default=False)
def tests(session: nox.Session) -> None:
    """The Python tests, on the package as a user would install it."""
    session.install(".[test]")
    session.run("pytest", "-q", "-n", "2", *session.posargs)


@nox.session(default=False)
def wheel(session: nox.Session) -> None:
    """A wheel and a source distribution; the wheel, installed, simulates."""
    session.install("build", "pytest")
    out = session.create_tmp()
    session.run("python", "-m", "build", "--outdir", out)
    session.install("--find-links", out, "stickslip")
    session.run("pytest", "-q", "packaging/test_installed.py")


if __name__ == "__main__":
    nox.main()
