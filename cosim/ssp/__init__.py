"""SSP (System Structure and Parameterization): systems written as 1.0, read as 1.0 or 2.0; and systems as one FMU.

    write        a system -> an SSP file                load         an SSP file -> a system
    structure    SystemStructure.ssd as data            connections  connections through nested systems
    parameters   parameter bindings and mappings        archive      archives of unknown origin
    container    a system -> one FMU, whose modelDescription.xml is made by container_description
"""
