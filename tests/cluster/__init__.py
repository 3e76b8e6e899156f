"""Studies on several processes and on a Dask cluster, on loopback; they compute, and do not wait for the clock."""
