"""Words, values and pieces of files that are wrong, or may be: what `wrong_use` draws from."""
NUMBERS = ["0", "-0", "-1", "nan", "inf", "-inf", "1e999", "-1e999", "1e308", "1e-320", "1" * 400, "0x10", "1_0", "1,5",
           "٣", "1e", ".", "+", "0.01", "7700", "85000", "1e9", "100", "3.5", "--1", ""]
WORDS = ["", " ", ".", "..", "/", "~", "~nobody/x", "../../esc", "a/b", "a=b", "=", "==", "=x.fmu", "x=",
         "a=~nobody.fmu",
         "nul\0l", "\x1b[31m", "\ud800", "é" * 300, "x" * 5000, "a\nb", "$\\frac$", "[red]", "%s%n", "None", "true",
         "null",
         "*", "plant", "plant.", ".mass", "plant.mass", "controller", "case1", "hold", "neural", "/dev/null",
         "/proc/self/mem",
         "{}", "'", '"', "-", "--", "--help-me", "🚀", "x" * 300 + ".fmu", "x" * 300 + ".yaml", "a,b", ",",
         "calibrated,"]
UNITS = ["deg", "rad", "ft", "ft/s", "km/s", "m", "slug/ft", "slug", "%", "°", "furlong", "deg deg", "e", "E5", "2",
         "ft/s2",
         "\0", "1/s", "s", "in", "-", ".", "e5e5", "d" * 3000]
VARIABLES = ["plant.mass", "plant.V_start", "plant.theta_start", "plant.start_at_trim", "plant.V", "plant.nope",
             "controller.kV", "controller.solve_trim", "controller.V", "controller.elevator_max",
             "controller.internal_step",
             "scenario.V_command_base", "scenario.h_command_step_time", "scenario.scale_lift_base", "nowhere.x",
             "plant",
             "plant.", ".x", "plant.mass.mass", "controller.fuel_ratio_min", "controller.fuel_ratio_max"]
COMMANDS = {  # command -> its arguments, its options: name -> what is drawn
    "run": (["hold", "--stop", "0.02"], ["--controller", "--preset", "--flavour", "--plant", "--step#", "--stop#",
            "--algorithm", "--uncertainty#", "--real-time#", "--time-limit#", "--set", "--record", "--decimate#",
            "--out", "--figures", "--columns#", "--open!"]),
    "compare": (["nowhere"], ["--controller", "--flavour", "--plant", "--step#", "--stop#", "--out", "--run",
                              "--figures", "--columns#", "--open!"]),
    "view": (["nothing"], ["!", "--out", "--open!"]),
    "playground": ([], ["--out"]),
    "info": ([], ["!"]),
    "trim": ([], ["--V#", "--h#", "--flavour"]),
    "linearize": (["--controller", "nobody"], ["!", "--V#", "--h#", "--controller", "--preset", "--plant", "--scale#",
                                               "--step#", "--set", "--of", "--time#", "--out"]),
    "simulate": (["nothing.ssp"], ["!", "--step#", "--start#", "--stop#", "--tolerance#", "--algorithm", "--set",
                                   "--input", "--record", "--decimate#", "--save", "--restore", "--out",
                                   "--time-limit#", "--figures", "--columns#", "--open!"]),
    "container": (["hold", "--out", "out.fmu"], ["!", "--connector", "--controller", "--preset", "--flavour", "--plant",
                                                 "--step#", "--uncertainty#", "--set", "--out"]),
    "ssp": (["hold", "--out", "out.ssp"], ["--controller", "--preset", "--flavour", "--plant", "--step#",
                                           "--uncertainty#", "--set"]),
    "check": (["nothing.fmu"], ["!", "--time-limit#", "--total-time-limit#", "--memory-limit#", "--file-limit#",
                                "--process-limit#", "--explain", "--ignore", "--format", "--fail-on", "--out",
                                "--open!"]),
    "recover": (["nothing"], ["!", "--open!"]),
    "campaign": (["nothing.yaml"], ["!", "--scheduler", "--workers#", "--out"]),
    "sweep": (["nowhere", "plant.mass=290:310:3"], ["--metric", "--success", "--controller", "--preset", "--flavour",
                                                    "--plant", "--step#", "--stop#", "--algorithm", "--set",
                                                    "--workers#", "--out"]),
    "fit": (["nothing.fmu", "nothing.csv"], ["!", "--parameter", "--signal", "--set", "--starts#", "--seed#", "--step#",
                                             "--start#", "--tolerance#", "--algorithm", "--workers#", "--time-limit#",
                                             "--out", "--figures", "--columns#"]),
    "tune": (["nobody"], ["--preset", "--flights", "--gain", "--evaluations#", "--draws#", "--seed#", "--sigma#",
                          "--workers#", "--out"]),
    "build": (["nobody"], ["!", "--flavour", "--out"]),
    "bench": (["nothing"], ["--nonsense"]),
}
ALGORITHMS = ["gauss-seidel", "jacobi", "multi-rate", "variable", "iterated", "magic", "", "gauss_seidel"]
OPTIONS = ["hold", "order", "tolerance", "passes", "rates", "controller", "plant", "scenario", "nobody", "", "h" * 2000]
CHOICES = ["linear", "constant", "scenario+controller+plant", "plant+plant", "+", "controller", "2", "3", "1"]
SCENARIO = {"name": "own", "stop": 0.02, "presets": {"scenario": "hold"}, "set": {"plant.V_start": 8000.0,
                                                                                "controller.solve_trim": True}}
CAMPAIGN = {
    "name": "own", "scenario": "hold", "controllers": ["neural"], "step": 0.01, "stop": 1.0, "runs": 4, "seed": 1,
    "sampling": "sobol", "dispersions": {
        "plant.mass": {"distribution": "normal", "mean": 1.0, "std": 0.05, "low": 0.8, "high": 1.2, "relative": True},
        "scenario.scale_lift": {"distribution": "sinusoid", "amplitude": 0.1, "period": 20.0},
        "plant.CL_alpha": {"distribution": "uniform", "low": 4.0, "high": 5.0}},
    "correlations": [{"draws": ["plant.mass", "plant.CL_alpha"], "coefficient": 0.5}],
    "success": {"near": "altitude_error_ft.max_abs < 20"}, "signals": {"share": 0.5, "record": ["plant.*"]}}
OWN = {key: CAMPAIGN[key] for key in ("name", "scenario", "controllers", "step", "stop", "success", "signals")}
CAMPAIGNS = [  # samples of one's own (`draws.csv` lies beside the file), grids, rules, rare failures, any system
    {**OWN, "samples": "draws.csv", "metrics": {"high": "max(plant.h)"}, "worst_by": "high"},
    {**CAMPAIGN, "correlations": [], "samples": "draws.csv", "dispersions": {
        "plant.CL_alpha": {"distribution": "empirical", "values": [4.0, 4.5, 5.0]}}},
    {**OWN, "sampling": "grid", "dispersions": {"plant.mass": {"low": 290, "high": 310, "points": 3},
                                                "controller.k_gamma": {"values": [0.3, 0.4]}}},
    {**CAMPAIGN, "sampling": "random", "stop_when": {"probability": "near", "half_width": 0.1, "confidence": 0.9}},
    {**{key: value for key, value in CAMPAIGN.items() if key != "runs"}, "sampling": "random", "rare": {
        "failure": "near", "method": "cross-entropy", "runs_per_level": 100, "most_levels": 3}},
    {"name": "own", "system": "AhvPlant.fmu", "variants": [{"name": "light", "set": {"AhvPlant.chord": 17.0}}, {
        "name": "other", "fmus": {"AhvPlant": "AhvPlant.fmu"}}], "start": 0.0, "stop": 0.5, "step": 0.01, "runs": 4,
     "tolerance": 1e-6, "seed": 1, "dispersions": {"AhvPlant.mass": {"distribution": "triangular", "low": 280.0,
                                                                      "mode": 300.0, "high": 320.0}},
     "success": {"high": "min(AhvPlant.h) > 0"}, "over_time": ["AhvPlant.h"]}]
SAMPLES = [["plant.mass", "scenario.scale_lift", "controller.solve_trim"], ["290", "1", "true"],
           ["300.125", "0.9", "false"], ["310", "1.1", "true"], ["305", "1e0", "0"]]
DATA = [["time", "AhvPlant.h", "AhvPlant.elevator"], ["0", "85000", "0.1"], ["0.01", "85000.1", "0.1"],
        ["0.02", "85000.2", "0.1"]]
DISTRIBUTIONS = ["uniform", "integer", "normal", "log-normal", "choice", "sinusoid", "cauchy"]
SYNTAX = ["[" * 5000, "a: " + "[" * 30 + "]" * 30, "a: &a [*a]", "%YAML 9.9\n---\na: 1", "a: !!python/object:os.x {}",
          "a: !!int ''", "a: !!float ''", "a: !!bool maybe", "a: !!timestamp x", "a: 2001-99-99", "a: 0" + "9" * 5000,
          "? [1]\n: 2", "- 1", "1", "", "\t", "a: b: c", "a: 1\n---\na: 2", "<<: 3", "<<: [1]", "name: own\n<<: *b",
          "a: 'x", "a: |\n x\n y", "\ufeffname: own", "a: \"\\ud800\"", "{" * 200, "a: " * 3000, "- " * 3000, "!" * 300,
          "&a " * 300, "* ", "a: 1:2:3:99999999999", "a: !!binary x", "a: !!set {1}", "a: !!omap [1]", "0o8: 1", "~: 1",
          "a: .inf", "1e999: 1", "\u0085\u2028", "\x00", "a: &x {b: &y [*x, *y]}",
          "a0: &a0 [x,x,x,x,x,x,x,x,x]\n" + "".join(f"a{i}: &a{i} [{','.join([f'*a{i - 1}'] * 9)}]\n"
                                                     for i in range(1, 9)),
          "m0: &m0 {a: 1}\n" + "".join(f"m{i}: &m{i} {{<<: [{','.join([f'*m{i - 1}'] * 9)}]}}\n" for i in range(1, 9))]
TERMS = ["altitude_error_ft.max_abs", "elevator_deg.travel", "protected_s", "saturated_s.elevator", "1", "1e999",
         "9" * 400, "0",
         "nan", "x", "True", "None", "'a'", "abs", "abs(1)", "abs(1, 2)", "abs()", "min(1)", "max()", "max(1, 2)",
         "min(*[1])",
         "abs(x=1)", "__import__('os')", "().__class__", "1j", "[1]", "{}", "lambda: 1", "(1)", "0x1f", "f'{1}'",
         "b''", "...", "1_0",
         "a.b.c", "altitude_error_ft", "max_abs", "١"]
BETWEEN = [" < ", " and ", " or ", " + ", " ** ", " / ", " == ", " != ", " <= ", " is ", " in ", " if ", " := ",
           " % ", " // ",
           " @ ", " not ", ",", " ", "\n", ";", "#", "\0", " > "]
EXPRESSIONS = ["-" * 990 + "1 < 2", "(" * 300 + "1" + ")" * 300, "not " * 240 + "1 < 2", "1 < 2" + " < 3" * 230,
               "1" + "+1" * 480,
               "2 ** 2 ** 2 ** 2 ** 9 ** 9 < 1", "9 ** 9 ** 9 < 1", "1 / 0 < 1", "", " ", "abs(a, 2) < 1",
               "min(x) < 1", "\ud800"]
ENCODINGS = ["UTF-7", "UTF-16", "UTF-32", "utf8", "idna", "punycode", "rot13", "hex", "zlib", "cp037",
             "EBCDIC-CP-US", "x" * 100_000,
             "", "latin-1", "unicode_escape", "mbcs", "undefined", "ASCII", "base64"]
ATTRIBUTES = ["x" * 100_000, "1e999", "", "-1", "&#x2028;", "../x", "9" * 5000, "nan", "%00", "http://[", "\0", "1 2 3",
              "&#0;", "\u202e", "%s", "%2e%2e/x", "file:///etc/passwd", "&x;"]
STRUCTURE = ['name="plant"', 'source="resources/', 'startElement="plant"', 'startConnector="V"', 'kind="input"',
             'stopTime="', '<ssd:Elements>', '<ssd:Connections>', 'version="1.0"',
             'type="application/x-fmu-sharedlibrary"',
             '<ssd:Connector ', 'unit="ft/s"', 'stepSize="']
FIELDS = ['modelIdentifier="AhvController"', 'guid="', 'fmiVersion="2.0"', 'name="V"', 'valueReference="0"',
          'start="7700.0"',
          'causality="input"', 'variability="fixed"', 'unit="ft/s"', 'max="16000.0"', 'index="8"', 'initial="exact"',
          '<Real ', '<ModelVariables>', 'canHandleVariableCommunicationStepSize="true"', 'factor="0.3048"',
          '<CoSimulation ']
