"""SSP 1.0 (System Structure and Parameterization): systems written and read.

    write        a system -> an SSP file                load         an SSP file -> a system
    structure    SystemStructure.ssd as data            connections  connections through nested systems
    parameters   parameter bindings and mappings        archive      archives of unknown origin
"""
