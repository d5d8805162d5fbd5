"""Makes a bucket on an S3 server, or copies its objects into a folder: bucket.py make|copy ENDPOINT BUCKET [FOLDER]."""

import os
import sys

import boto3

command, endpoint, bucket = sys.argv[1:4]
client = boto3.client(
    "s3", endpoint_url=endpoint, region_name="us-east-1", aws_access_key_id="key", aws_secret_access_key="secret"
)
if command == "make":
    client.create_bucket(Bucket=bucket)
else:
    pages = client.get_paginator("list_objects_v2").paginate(Bucket=bucket)
    for entry in [entry for page in pages for entry in page.get("Contents", [])]:
        path = os.path.join(sys.argv[4], entry["Key"])
        os.makedirs(os.path.dirname(path), exist_ok=True)
        client.download_file(bucket, entry["Key"], path)
