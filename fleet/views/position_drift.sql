-- Drift of position between redundant channels
--
-- Encoders with several channels send a position of each (6020h:01, 6020h:02, ...; 6004h is that of the whole device).
-- Of each second in which two of them were sent the mean difference is taken; the drift is how far that moves within
-- a capture. Redundant channels that turn against each other, or restart at another place, show as a large drift, too.
CREATE VIEW position_drift AS
WITH seconds AS (
    SELECT capture, channel, node, index, sub, date_trunc('second', t) AS second, avg(value) AS position
    FROM signals
    WHERE index IN (24580, 24608)
    GROUP BY capture, channel, node, index, sub, date_trunc('second', t)
)
SELECT
    a.capture, a.channel, a.node, a.index, a.sub, b.index AS other_index, b.sub AS other_sub,
    count(*) AS seconds,
    avg(b.position - a.position) AS mean_difference,
    max(b.position - a.position) - min(b.position - a.position) AS drift
FROM seconds a
JOIN seconds b
    ON b.capture = a.capture AND b.channel = a.channel AND b.node = a.node AND b.second = a.second
    AND (b.index > a.index OR (b.index = a.index AND b.sub > a.sub))
GROUP BY a.capture, a.channel, a.node, a.index, a.sub, b.index, b.sub;
