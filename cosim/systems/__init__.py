"""Systems from files of any kind: one FMU, an SSP, or a YAML file that lists FMUs and the wires between them.

    load         a file -> a system           system_file  the YAML file
    words        what users say of a system's variables
    simulate     `ahv simulate`
"""
