"""The program behind the command `rockslip`; what is public stands in the module `rockslip`."""

VERSION = "0.2.0"
