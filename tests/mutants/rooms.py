"""Which files are mutated, and which tests must notice: the table of the rooms."""
from fnmatch import fnmatch

# Campaigns without what costs more than it notices here: other processes, kills, a second and a third campaign.
INSIDE = "system/campaign_inside -k not kill and not command and not division and not too_long"
# A room: pairs of a pattern of files and its tests, in stages, of which the first that fails ends the trial. The
# quick tests come first. The first pattern that fits a file counts; None: the file is not mutated (what it draws or
# prints is looked at by people, or it is run on foreign machines only).
ROOMS: dict[str, list[tuple[str, list[str] | None]]] = {
    "models": [
        ("ahv_plant_fmu/*", ["unit/test_model_numbers", "unit/test_trim unit/test_coupling unit/test_models",
                             "unit/test_noise unit/test_instrumented", "conformance/test_description"]),
        ("ahv_ctrl_fmu/resilient*", ["unit/test_model_numbers", "unit/test_models"]),
        ("ahv_ctrl_fmu/*", ["unit/test_model_numbers",
                            "unit/test_linear unit/test_sections unit/test_models unit/test_neural",
                            "conformance/test_description"]),
        ("cosim/vehicle/scenario_model.py", ["unit/test_model_numbers", "unit/test_scenario unit/test_models",
                                             "conformance/test_description"]),
    ],
    "wrapper": [
        ("fmus/wrapper/windows/*", None),
        ("fmus/wrapper/*.c", ["conformance/test_native_refusals", "conformance/test_native_arguments",
                              "conformance/test_contract", "conformance/test_native_hosts -k sanitizers",
                              "conformance/test_clock"]),
    ],
    "fmus": [
        ("fmus/documentation.py", ["unit/test_written_files"]),
        ("fmus/equations.py", ["unit/test_equations"]),
        ("fmus/description3.py", ["conformance/test_fmi3_files"]),
        ("fmus/experiments.py", ["conformance/test_experiments"]),
        ("fmus/release.py", ["system/test_release"]),
        ("fmus/check_model.py", ["unit/test_model_mistakes conformance/test_anybodys_model"]),
        ("fmus/[rs]*.py", ["unit/test_slave unit/test_models", "conformance/test_contract"]),
        ("fmus/native_compiler.py", ["platforms conformance/test_native_files -k not page"]),
        ("fmus/*.py", ["unit/test_written_files unit/test_pack unit/test_units unit/test_models",
                       "unit/test_model_mistakes conformance/test_anybodys_model",
                       "conformance/test_description conformance/test_python_flavour",
                       "conformance/test_native_refusals"]),
    ],
    "algorithms": [
        ("cosim/master/algorithms/variable.py", ["system/test_variable_steps", "system/test_master_algorithms"]),
        ("cosim/master/algorithms/*.py", ["system/test_master_algorithms", "system/test_rows",
                                          "system/test_master_ends", "system/test_master_wiring"]),
    ],
    "master": [
        ("cosim/master/algorithms/*", None),
        ("cosim/master/plot.py", None),
        ("cosim/master/unpack.py", ["conformance/check/test_check_archive", "system/test_ssp_bad_files"]),
        ("cosim/master/info.py", ["system/test_python_info"]),
        ("cosim/master/parameter_set.py", ["unit/test_quantities system/test_ssp_reading"]),
        ("cosim/master/loop.c", ["system/test_loop_programs", "system/test_master_loops", "system/test_tables"]),
        ("cosim/master/*compile*.py", ["system/test_compile_loop", "system/test_master_loops"]),
        ("cosim/master/evaluate.py", None),
        ("cosim/master/measures.py", None),
        ("cosim/master/condition.py", None),
        ("cosim/master/[wdq]*.py", ["unit/test_master_order unit/test_dependencies unit/test_quantities",
                                    "system/test_master_wiring", "system/test_master_answers",
                                    "system/test_python_library"]),
        ("cosim/master/[il]*.py", ["system/test_master_answers", "system/test_master_initialise",
                                   "system/test_master_wiring system/test_master_faults", "system/test_master_ends"]),
        ("cosim/master/*.py", ["unit/test_course unit/test_pack unit/test_read_member",
                               "system/test_master_wiring -k not masters",
                               "system/test_master_answers", "system/test_rows",
                               "system/test_python_signals system/test_python_info", "system/test_python_library",
                               "system/test_master_faults"]),
    ],
    "expressions": [
        ("cosim/master/condition.py", ["unit/test_measures"]),
        ("cosim/master/evaluate.py", ["unit/test_measures unit/test_campaign_criteria"]),
        ("cosim/master/measures.py", ["unit/test_measures unit/test_campaign_criteria"]),
    ],
    "ssp": [
        ("cosim/ssp/*.py", ["unit/test_quantities system/test_ssp_reading", "system/test_ssp_bad_files",
                            "system/test_ssp_writing"]),
    ],
    "campaign": [
        ("cosim/campaign/charts.py", ["unit/test_campaign_charts"]),
        ("cosim/campaign/curves.py", ["unit/test_campaign_pages", INSIDE]),
        ("cosim/campaign/shown.py", ["unit/test_campaign_pages system/test_campaign_texts", INSIDE]),
        ("cosim/campaign/labels.py", ["unit/test_campaign_pages unit/test_campaign_charts"]),
        ("cosim/campaign/distributions.py", ["unit/test_campaign_distributions",
                                             "unit/test_campaign_sampling -k not covers", "system/test_campaign_bad"]),
        ("cosim/campaign/samples.py", ["unit/test_campaign_samples", "system/test_campaign_bad"]),
        ("cosim/campaign/grid.py", ["unit/test_campaign_grid"]),
        ("cosim/campaign/sweep.py", ["unit/test_campaign_grid", "system/test_campaign_own"]),
        ("cosim/campaign/rare*.py", ["unit/test_campaign_rare_estimate", "system/test_campaign_rare"]),
        ("cosim/campaign/margin.py", ["unit/test_campaign_margin", "system/test_campaign_rare"]),
        ("cosim/campaign/sequential.py", ["unit/test_campaign_sequential"]),
        ("cosim/campaign/front.py", ["unit/test_campaign_front", "system/test_campaign_growth"]),
        ("cosim/campaign/subject.py", ["system/test_campaign_file", "system/test_campaign_system"]),
        ("cosim/campaign/[es]*.py", ["unit/test_campaign_statistics unit/test_campaign_sampling -k not covers",
                                     "system/test_campaign_file unit/test_campaign_summary",
                                     "unit/test_campaign_nominal", INSIDE]),
        ("cosim/campaign/worker.py", ["unit/test_campaign_loading", "system/test_campaign_worker",
                                      "system/test_campaign_fatal", INSIDE]),
        ("cosim/campaign/*.py", ["unit/test_campaign_criteria unit/test_campaign_summary",
                                 "system/test_campaign_file unit/test_campaign_nominal", INSIDE]),
    ],
    "fitting": [
        ("cosim/fitting/picture.py", None),
        ("cosim/fitting/*.py", ["system/test_fit system/test_fit_bad -k not process and not command"]),
    ],
    "ecosystems": [
        ("cosim/ecosystems/function.py", ["system/test_function"]),
        ("cosim/ecosystems/*.py", ["system/test_environment -k not processes", "system/test_function"]),
    ],
    "pages": [
        ("cosim/playground/*.py", ["system/test_playground"]),
        ("cosim/pages/*.py", ["system/test_pages", "unit/test_campaign_pages"]),
    ],
}
# The FMUs that a room's tests are tried with, for Linux only, which saves most of the building; None: all of ours. A
# stage that begins with "platforms" has the smallest one for every platform.
FMUS: dict[str, tuple[str, ...] | None] = {"models": None, "wrapper": ("AhvScenario", "AhvPlant", "AhvController"),
                                           "fmus": ("AhvPlant", "AhvScenario", "AhvController")}


def tests(room: str, file: str) -> list[str] | None:
    """The stages of tests for a file of the room; None if it is not among those mutated."""
    return next((stages for pattern, stages in ROOMS[room] if fnmatch(file, pattern)), None)
