// The search shows a piece of each page that it finds, which it fetches; a browser refuses that for pages of a disk.
if (location.protocol === "file:") DOCUMENTATION_OPTIONS.SHOW_SEARCH_SUMMARY = false;
