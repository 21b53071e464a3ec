"""`python -m i2pdsl` is the program `i2p`."""

from i2pdsl.cli import main

main()
