-- Bus load
--
-- The mean load of each bus and its fullest tenth of a second, in percent.
CREATE VIEW bus_load AS
SELECT
    capture, channel, t, bit_rate, bit_rate_inferred, frames, frames_per_second, load_percent, peak_percent, peak_t
FROM statistics
WHERE service IS NULL;
