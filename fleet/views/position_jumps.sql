-- Position jumps, and what happened before
--
-- Each capture that shows a position jump of an encoder, with the events on that bus in the second before it.
CREATE VIEW position_jumps AS
SELECT
    f.capture, f.channel, f.node, f.t AS jump_t, f.message,
    arrow_cast(f.t, 'Int64') - arrow_cast(e.t, 'Int64') AS before_ns,
    e.event, e.node AS event_node, e.text, e.detail
FROM findings f
LEFT JOIN events e
    ON e.capture = f.capture AND e.channel = f.channel
    AND e.t <= f.t AND arrow_cast(f.t, 'Int64') - arrow_cast(e.t, 'Int64') <= 1000000000
WHERE f.rule = 'encoder/position-jump';
