-- SDO latencies
--
-- How long whole SDO transfers took, by product, software version, month and kind of transfer.
CREATE VIEW sdo_latencies AS
SELECT
    n.vendor_id, n.product_code, n.software_version,
    date_trunc('month', e.started) AS month, e.direction, e.mode,
    count(*) AS transfers,
    approx_percentile_cont(0.5) WITHIN GROUP (ORDER BY e.duration_ns) AS p50_ns,
    approx_percentile_cont(0.99) WITHIN GROUP (ORDER BY e.duration_ns) AS p99_ns,
    max(e.duration_ns) AS max_ns
FROM events e
LEFT JOIN nodes n ON n.capture = e.capture AND n.channel = e.channel AND n.node = e.node
WHERE e.event = 'sdo' AND e.outcome = 'complete'
GROUP BY n.vendor_id, n.product_code, n.software_version, date_trunc('month', e.started), e.direction, e.mode;
