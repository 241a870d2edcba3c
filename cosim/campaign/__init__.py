"""Campaigns: thousands of flights on Dask, with the values that a file declares uncertain drawn for each.

    spec        the campaign file's models          dispersions  what is uncertain, checked against the FMUs
    sampling    the draws of run k                  criteria     metrics and success of the file
    plan        file + FMUs -> what is flown        worker       a batch of runs, on a Dask worker
    nominal     a flight of each law before         engine       batches to a cluster and back
    cluster     Dask on this machine, or there      code         which code flies, here and on workers
    store       Parquet, written during the campaign; receipt: its checksums; resume: what is there already
    statistics  probabilities, correlations         report       report.json; report.html: shown (its runs), curves,
    charts      its pictures; labels: words there                overview (all runs), page (tables), scripts/
    progress    what is said meanwhile              rerun        the command that repeats one run
    rare        how likely a rare failure is; rare_rules, rare_flights, rare_report: its file, flights and page
    margin      how far a run is from failing
"""
