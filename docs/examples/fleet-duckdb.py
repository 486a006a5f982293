"""Frames by service, of a lake that canvass-fleet made, read by DuckDB: python fleet-duckdb.py LAKE"""

import sys

import duckdb

lake = sys.argv[1].replace("'", "''")
rows = duckdb.sql(f"""
    SELECT service, count(*) AS frames
    FROM read_parquet('{lake}/messages/*/*.parquet', hive_partitioning=true)
    GROUP BY service ORDER BY service
""").fetchall()
print("service,frames")
for service, frames in rows:
    print(f"{service},{frames}")
