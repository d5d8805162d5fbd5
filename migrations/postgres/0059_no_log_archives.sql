-- Contacts are archived from the database only. A connector archives Kafka's topic.
DROP TABLE log_archives;
