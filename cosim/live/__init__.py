"""A page that shows a running flight, and steps its inputs: any flight, with what its room says of gauges and buttons.

The flight flies in a process of its own (`master.isolated`). Here, in its parent, threads serve the page, its events
and its steps to browsers of this machine.
"""
