"""Results of an identification: report, parameter file, figures."""
