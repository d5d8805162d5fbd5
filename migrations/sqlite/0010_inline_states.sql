-- States stay in their rows: only PostgreSQL moves large values out of them, so that there is nothing to change here.
SELECT 1;
