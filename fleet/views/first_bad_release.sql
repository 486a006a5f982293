-- First bad release
--
-- Of each case that is bad in some release of a product: the first release in which it was, and the last good one
-- before that. Releases are the software versions, in the order in which they were first tested.
CREATE VIEW first_bad_release AS
WITH releases AS (
    SELECT
        v.id, r.vendor_id, r.product_code, r.software_version,
        min(r.t) AS tested,
        count(CASE WHEN v.verdict IN ('fail', 'error') THEN 1 END) > 0 AS bad
    FROM verdicts v
    JOIN runs r ON r.run = v.run
    WHERE v.kind = 'test' AND v.verdict <> 'not_applicable'
    GROUP BY v.id, r.vendor_id, r.product_code, r.software_version
),
firsts AS (
    SELECT id, vendor_id, product_code, min(tested) AS tested
    FROM releases WHERE bad
    GROUP BY id, vendor_id, product_code
)
SELECT
    f.id, f.vendor_id, f.product_code, bad.software_version AS first_bad, f.tested,
    max(good.tested) AS last_good_tested
FROM firsts f
JOIN releases bad
    ON bad.id = f.id AND (bad.vendor_id IS NOT DISTINCT FROM f.vendor_id)
    AND (bad.product_code IS NOT DISTINCT FROM f.product_code) AND bad.tested = f.tested AND bad.bad
LEFT JOIN releases good
    ON good.id = f.id AND (good.vendor_id IS NOT DISTINCT FROM f.vendor_id)
    AND (good.product_code IS NOT DISTINCT FROM f.product_code) AND good.tested < f.tested AND NOT good.bad
GROUP BY f.id, f.vendor_id, f.product_code, bad.software_version, f.tested;
