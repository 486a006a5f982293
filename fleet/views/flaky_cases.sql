-- Flaky cases
--
-- Cases that came out differently on the same software version of a product: in repetitions, or from run to run.
CREATE VIEW flaky_cases AS
SELECT
    v.id, r.vendor_id, r.product_code, r.software_version,
    count(*) AS runs,
    count(CASE WHEN v.verdict IN ('pass', 'tolerated', 'deviation') THEN 1 END) AS good,
    count(CASE WHEN v.verdict IN ('fail', 'error', 'inconclusive') THEN 1 END) AS bad,
    count(CASE WHEN v.flaky THEN 1 END) AS flaky_runs
FROM verdicts v
JOIN runs r ON r.run = v.run
WHERE v.kind = 'test' AND v.verdict <> 'not_applicable'
GROUP BY v.id, r.vendor_id, r.product_code, r.software_version
HAVING count(CASE WHEN v.flaky THEN 1 END) > 0
    OR (count(CASE WHEN v.verdict IN ('pass', 'tolerated', 'deviation') THEN 1 END) > 0
        AND count(CASE WHEN v.verdict IN ('fail', 'error', 'inconclusive') THEN 1 END) > 0);
