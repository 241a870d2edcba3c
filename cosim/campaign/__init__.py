"""Campaigns: thousands of flights on Dask, with the values that a file declares uncertain drawn for each.

    spec        the campaign file's models          dispersions  what is uncertain, checked against the FMUs
    sampling    the draws of run k                  criteria     success, as expressions on the metrics
    plan        file + FMUs -> what is flown        worker       a batch of runs, on a Dask worker
    engine      batches to a cluster and back       store        Parquet, written during the campaign; resume
    statistics  probabilities, correlations         charts, report   report.html and its figures
    progress    a progress bar                      rerun        the command that repeats one run
    command     `ahv campaign`
"""
