-- EMCY rates
--
-- How often each error code was reported per hour in which devices of a product and software version were recorded.
CREATE VIEW emcy_rates AS
SELECT
    d.vendor_id, d.product_code, d.software_version, e.emcy_code,
    count(*) AS reports,
    count(DISTINCT e.capture) AS captures,
    max(h.hours) AS hours,
    CASE WHEN max(h.hours) > 0 THEN count(*) / max(h.hours) END AS per_hour
FROM events e
JOIN nodes d ON d.capture = e.capture AND d.channel = e.channel AND d.node = e.node
JOIN (
    SELECT
        coalesce(vendor_id, 0) AS vendor, coalesce(product_code, 0) AS product,
        coalesce(software_version, '') AS software,
        sum(arrow_cast(t_last, 'Int64') - arrow_cast(t, 'Int64')) / 3.6e12 AS hours
    FROM nodes WHERE present
    GROUP BY coalesce(vendor_id, 0), coalesce(product_code, 0), coalesce(software_version, '')
) h
    ON h.vendor = coalesce(d.vendor_id, 0) AND h.product = coalesce(d.product_code, 0)
    AND h.software = coalesce(d.software_version, '')
WHERE e.event = 'emcy' AND e.emcy_state = 'raised'
GROUP BY d.vendor_id, d.product_code, d.software_version, e.emcy_code;
