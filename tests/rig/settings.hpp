/* The numbers of a hexid configuration. YAML as in config/ and --print-config: a key per line,
 * sections by indent, lists in brackets or an item per line. */
#pragma once
#include "bodies.hpp"

#include <map>
#include <string>
#include <vector>

double number(const std::string &text); /* throws unless the whole text is a number */

class Settings
{
public:
    /* Loads a file, whose keys replace existing ones. */
    void load(const std::string &file);

    /* Assigns "section.key=value" to an existing key. */
    void set(const std::string &assignment);

    /* Access by "section.key". Lists keep their order, points follow one another; true and false
     * are 1 and 0; a text has no numbers. */
    const std::vector<double> &all(const std::string &key) const;
    double at(const std::string &key) const; /* its only value */
    double at(const std::string &key, int place) const; /* value of this leg or axis, or the only
                                                         * one */
    Vec6 legs(const std::string &key) const; /* all six values */

private:
    std::map<std::string, std::vector<double>> values;
};

/* Joints at neutral in {M}, whose origin is the payload's configured mass centre; m. */
Points upper_joints(const Settings &s);
Points lower_joints(const Settings &s);
