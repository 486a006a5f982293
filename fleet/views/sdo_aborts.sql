-- SDO aborts
--
-- Which objects of which products and software versions refuse what, and how often.
CREATE VIEW sdo_aborts AS
SELECT
    n.vendor_id, n.product_code, n.software_version,
    e.index, e.sub, e.direction, e.abort_code, e.abort_by, min(e.text) AS reason,
    count(*) AS aborts, count(DISTINCT e.capture) AS captures
FROM events e
LEFT JOIN nodes n ON n.capture = e.capture AND n.channel = e.channel AND n.node = e.node
WHERE e.event = 'sdo' AND e.outcome = 'aborted'
GROUP BY n.vendor_id, n.product_code, n.software_version, e.index, e.sub, e.direction, e.abort_code, e.abort_by;
