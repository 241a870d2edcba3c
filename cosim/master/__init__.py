"""Any system of FMUs, flown: files, instances, wiring, tick loops, algorithms, recording."""
