#include "check_report.h"
int check_html(const struct check_report *report, char **page, struct error *error) { (void)report; *page = NULL; return error_set(error, STATUS_IO, "not yet"); }
