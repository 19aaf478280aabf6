"""How well models predict rows that were held out, beside the plainest fits that anybody would try."""
