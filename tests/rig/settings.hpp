/*
 * The numbers of a hexid configuration. YAML as config/ and --print-config have it: a key a line,
 * sections by indent, lists in brackets or an item a line.
 */
#pragma once
#include "bodies.hpp"

#include <map>
#include <string>
#include <vector>

double number(const std::string &text); /* throws unless the whole text is one */

class Settings
{
public:
    /* Keys of the file replace those that are there already. */
    void load(const std::string &file);

    /* "section.key=value", for a key that is there already. */
    void set(const std::string &assignment);

    /* By "section.key". A list's numbers are in its order, those of points one point after another;
     * true and false are 1 and 0; a text has none. */
    const std::vector<double> &all(const std::string &key) const;
    double at(const std::string &key) const; /* the only one */
    double at(const std::string &key, int place) const; /* of this leg or axis, or the only one */
    Vec6 legs(const std::string &key) const; /* all six of them */

private:
    std::map<std::string, std::vector<double>> values;
};

/* Joints at neutral in {M}, whose origin is the payload's configured mass centre; m. */
Points upper_joints(const Settings &s);
Points lower_joints(const Settings &s);
