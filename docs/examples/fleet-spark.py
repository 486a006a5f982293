"""Frames by service, of a lake that canvass-fleet made, read by Apache Spark (Java 17 or later): python fleet-spark.py LAKE"""

import sys

from pyspark.sql import SparkSession

spark = (
    SparkSession.builder.master("local[1]")
    .config("spark.ui.enabled", "false")
    # Its own time stamps have microseconds: nanoseconds become numbers.
    .config("spark.sql.legacy.parquet.nanosAsLong", "true")
    .getOrCreate()
)
spark.sparkContext.setLogLevel("ERROR")
rows = spark.read.parquet(f"{sys.argv[1]}/messages").groupBy("service").count().orderBy("service").collect()
print("service,frames")
for row in rows:
    print(f"{row['service']},{row['count']}")
spark.stop()
