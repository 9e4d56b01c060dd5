"""All summits of a surface under one plane: independent or elastically coupled."""
