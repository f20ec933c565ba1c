"""Modules with the names, arguments and answers of other packages, calculated by Tumble.

`tumble.compat.allantools` replaces AllanTools 2024.6, `tumble.compat.imucal` replaces imucal 2.6.
"""
