"""From evidence to a verdict: where the gap is, which effects remain, what objections stand."""
