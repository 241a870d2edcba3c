"""Records the experiments that travel in the controllers' FMUs (FMI-LS-REF), into ahv_ctrl_fmu/experiments/.

    .venv/bin/python benchmarks/record_experiments.py

The loop is flown; the measurements and commands become the inputs of an experiment, rounded as a sensor would have
them. The law alone is then stepped through these rounded inputs, which gives the golden outputs.
"""
import csv
import random
from dataclasses import replace
from io import StringIO
from pathlib import Path
from xml.etree.ElementTree import Element, SubElement

import numpy as np

from cosim.master.fly import fly
from cosim.master.fmu import FmuFile
from cosim.master.instance import Instance
from cosim.vehicle import scenarios
from cosim.vehicle.closed_loop import closed_loop, fmu_path
from cosim.vehicle.registry import LAWS, Model
from fmus.description import parameter_set, xml_bytes

ROOT = Path(__file__).parents[1]
FLIGHT_STEP = 0.01   # s
TOLERANCE = 1e-6     # of nominal
DIGITS = {"V": 3, "h": 2, "gamma": 7, "theta": 7, "Q": 6, "V_command": 3, "h_command": 2}  # after the decimal point
GROUPS = ("thrust", "lift", "drag", "moment", "forces")
DRAWS, SEED = 4, 22
