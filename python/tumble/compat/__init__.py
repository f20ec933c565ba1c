"""Modules with the names, arguments and answers of other packages, calculated by Tumble.

`tumble.compat.allantools` stands for AllanTools 2024.6, `tumble.compat.imucal` for imucal 2.6.
"""
