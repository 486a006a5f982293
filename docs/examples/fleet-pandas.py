"""Frames by service, of a lake that canvass-fleet made, read by pandas: python fleet-pandas.py LAKE"""

import sys

import pandas

messages = pandas.read_parquet(f"{sys.argv[1]}/messages", columns=["service"])
answer = messages["service"].astype(str).value_counts().sort_index()
print(answer.rename_axis("service").rename("frames").to_csv(), end="")
