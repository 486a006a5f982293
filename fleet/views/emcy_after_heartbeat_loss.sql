-- Errors within a second after a heartbeat loss
--
-- Each EMCY that a node raised within a second after some node's heartbeats were lost or late, with the identity of the
-- one that raised it: `WHERE emcy_code = 33072` are those with 8130h.
CREATE VIEW emcy_after_heartbeat_loss AS
SELECT
    e.capture, e.channel, e.t, e.node, e.emcy_code, e.text,
    f.node AS lost_node, f.rule, f.t AS lost_t,
    arrow_cast(e.t, 'Int64') - arrow_cast(f.t, 'Int64') AS after_ns,
    n.vendor_id, n.product_code, n.revision_number, n.software_version
FROM findings f
JOIN events e
    ON e.capture = f.capture AND e.channel = f.channel AND e.event = 'emcy' AND e.emcy_state = 'raised'
    AND e.t >= f.t AND arrow_cast(e.t, 'Int64') - arrow_cast(f.t, 'Int64') <= 1000000000
LEFT JOIN nodes n ON n.capture = e.capture AND n.channel = e.channel AND n.node = e.node
WHERE f.rule IN ('nodes/lost', 'nodes/heartbeat-late', 'nodes/heartbeat-ended', 'nodes/heartbeat-missing');
