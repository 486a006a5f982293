-- Heartbeat losses per revision
--
-- How often devices of a product, revision and software version dropped out or sent heartbeats late, and in how many
-- of the captures that have them. Nodes whose identity no capture shows are rows with empty products.
CREATE VIEW heartbeat_losses AS
SELECT
    n.vendor_id, n.product_code, n.revision_number, n.software_version,
    count(DISTINCT n.capture) AS captures,
    count(DISTINCT CASE WHEN f.rule IS NOT NULL THEN n.capture END) AS captures_with_losses,
    coalesce(sum(f.count), 0) AS losses
FROM nodes n
LEFT JOIN findings f
    ON f.capture = n.capture AND f.channel = n.channel AND f.node = n.node
    AND f.rule IN ('nodes/lost', 'nodes/heartbeat-late', 'nodes/heartbeat-ended', 'nodes/heartbeat-missing')
WHERE n.present
GROUP BY n.vendor_id, n.product_code, n.revision_number, n.software_version;
