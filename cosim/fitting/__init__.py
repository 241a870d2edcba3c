"""Parameters of a system fitted to measured signals: `ahv fit`.

    fit          from words to a folder of results
    data         measured flights: which columns drive inputs, which are compared
    parameters   what is fitted, its bounds and size
    flown        the flights flown with trial values, in processes of their own
    search       least squares, noise levels, several starts
    certainty    intervals, correlation, and why they cannot be trusted
    picture      data, fit and residuals
"""
