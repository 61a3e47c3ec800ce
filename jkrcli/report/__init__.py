"""One object per result: columns, summary (JSON), words, figure; and the files and pictures of them."""
