"""The master: flies any system of FMUs.

    system        what to fly, as data                  fmu           FMU files
    unpack        archives of unknown origin            instance      an instance of an FMU, and what it says
    description   modelDescription.xml as data          declared      what it says of a variable
    quantities    units and conversions                 parameter_set values of presets and of SSP files
    xml_file      XML, that of SSP validated            notes         notes to the user on stderr
    dependencies  which output depends on which input
    initialise    from instantiated to ready to step    wiring        a loaded system as arrays, which wirer builds
    program       what a tick does, as rows of numbers  loop_plain, loop_compiled   what carries programs out
    compile_loop  the latter's library, from loop.c
    algorithms    Jacobi, Gauss-Seidel and others       loaded        a loaded system: initialise, run programs, reset
    fly           from start to stop                    flight        what a flight left
    recording     rows into memory or a file            publish       results that appear together, in a folder
    recover       results of a killed flight            guard         the end of a process and all that it started
    table         inputs over time                      look_up       what a table has at a tick, for the loops
    state         a flight saved and gone on from       ssp2          SSP 2.0 in the words of 1.0
    pace          real time                             isolated      a flight in a process of its own
    desk          inputs stepped while it flies
    last_call     the current FMU call, for `isolated`  results       a flight written to a folder
    standards     what differs between versions of FMI  fmi2, fmi3    each of them
    library       the shared library of an FMU          logger        what FMUs log
    connections   which connections the FMUs allow
"""
