-- States stay in their rows.

-- A state is some 3.4 KB, and PostgreSQL moves values out of rows of more than 2 KB. What is outside is written anew with each
-- update, in a table of its own whose dead rows only a vacuum removes: at 5000 contacts a second of 200 whiskers it grew by
-- 8 MB a second, faster than autovacuum follows. In the row, with the room that the fill factor leaves beside it, an update
-- uses the place of the one before. Rows that are there follow with their next update.
ALTER TABLE whiskers SET (toast_tuple_target = 8160);
ALTER TABLE robots SET (toast_tuple_target = 8160);
