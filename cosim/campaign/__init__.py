"""Campaigns: a file says what is uncertain, thousands of flights on Dask say how often it matters.

    spec      the campaign file's models            source    YAML with line numbers
    sampling  the draws of run k                    criteria  expressions on the metrics
    plan      file + FMUs -> what is flown          worker    a batch of runs, on a Dask worker
    engine    batches to a cluster and back         store     Parquet, written as it goes; resume
    statistics, charts, report                      progress  what a terminal shows meanwhile
"""
