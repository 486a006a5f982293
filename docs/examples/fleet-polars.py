"""Frames by service, of a lake that canvass-fleet made, read by Polars: python fleet-polars.py LAKE"""

import sys

import polars

messages = polars.scan_parquet(f"{sys.argv[1]}/messages/**/*.parquet", hive_partitioning=True)
service = polars.col("service").cast(polars.String)
answer = messages.group_by(service).agg(polars.len().alias("frames")).sort("service").collect()
print(answer.write_csv(), end="")
