"""`python -m stickslip` is the command `stickslip`."""

from stickslip.cli.commands import main

if __name__ == "__main__":
    main()
