#include "settings.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>
#include <stdexcept>

constexpr double kPi = 3.14159265358979323846;
constexpr size_t kNone = std::string::npos;

double number(const std::string &text)
{
    size_t end = 0;
    const double value = text.empty() ? NAN : std::stod(text, &end);
    if (end != text.size() || !std::isfinite(value))
        throw std::runtime_error("not a number: '" + text + "'");
    return value;
}

/* Reads one number or a list; returns none if any part of it is text. */
static std::vector<double> numbers(std::string text)
{
    const std::string between = "[],";
    for (char &c : text)
        if (between.find(c) != kNone)
            c = ' ';
    std::istringstream in(text);
    std::vector<double> found;
    for (std::string word; in >> word;)
        try {
            found.push_back(word == "true" ? 1 : word == "false" ? 0 : number(word));
        } catch (const std::exception &) {
            return {};
        }
    return found;
}

/* Reads a line without its comment, joined with the following lines of a list in brackets. */
static bool next_line(std::istream &in, std::string &line)
{
    line.clear();
    std::string part;
    do {
        if (!std::getline(in, part))
            return !line.empty();
        line += part.substr(0, part.find('#'));
    } while (std::count(line.begin(), line.end(), '[') > std::count(line.begin(), line.end(), ']'));
    return true;
}

void Settings::load(const std::string &file)
{
    std::ifstream in(file);
    if (!in)
        throw std::runtime_error("cannot read " + file);
    std::map<std::string, std::vector<double>> found;
    std::vector<std::pair<size_t, std::string>> sections; /* indent and full key */
    for (std::string line; next_line(in, line);) {
        const size_t indent = line.find_first_not_of(" \t\r");
        if (indent == kNone)
            continue;

        size_t start = indent; /* indent of the text after an item's dash, or after the dashes of
                                * nested items */
        while (start != kNone && line.compare(start, 2, "- ") == 0)
            start = line.find_first_not_of(' ', start + 1);
        const bool item = start != indent;
        while (!sections.empty() && sections.back().first + !item > indent)
            sections.pop_back();
        const std::string section = sections.empty() ? "" : sections.back().second;
        if (item) {
            const auto more = start == kNone ? std::vector<double>() : numbers(line.substr(start));
            found[section].insert(found[section].end(), more.begin(), more.end());
            continue;
        }

        const size_t colon = line.find(':');
        if (colon == kNone)
            continue;
        const std::string key =
            (section.empty() ? "" : section + ".") + line.substr(indent, colon - indent);
        const std::string value = line.substr(colon + 1);
        const size_t first = value.find_first_not_of(" \t\r");
        if (first == kNone)
            sections.emplace_back(indent, key);
        else if (value[first] == '{')
            throw std::runtime_error(file + ": " + key + ": write a section's keys a line each");
        else
            found[key] = numbers(value);
    }
    for (auto &[key, list] : found)
        values[key] = list;
}

void Settings::set(const std::string &assignment)
{
    const size_t at = assignment.find('=');
    const auto known = values.find(assignment.substr(0, at));
    if (at == kNone || known == values.end())
        throw std::runtime_error("no such key: '" + assignment + "'");
    const std::string value = assignment.substr(at + 1);
    known->second = numbers(value);
    if (known->second.empty() && value != "[]")
        throw std::runtime_error("not a number: '" + assignment + "'");
}

const std::vector<double> &Settings::all(const std::string &key) const
{
    const auto found = values.find(key);
    if (found == values.end())
        throw std::runtime_error("the configuration has no " + key);
    return found->second;
}

double Settings::at(const std::string &key) const
{
    const auto &list = all(key);
    if (list.size() != 1)
        throw std::runtime_error(key + ": one number");
    return list[0];
}

double Settings::at(const std::string &key, int place) const
{
    const auto &list = all(key);
    const size_t k = list.size() == 1 ? 0 : static_cast<size_t>(place);
    if (k >= list.size())
        throw std::runtime_error(key + ": one number, or a list of one a leg or axis");
    return list[k];
}

Vec6 Settings::legs(const std::string &key) const
{
    Vec6 v;
    for (int i = 0; i < kLegs; i++)
        v[i] = at(key, i);
    return v;
}

/* Reads the six points of a drawing; returns false if the configuration has none. */
static bool drawn(const Settings &s, const std::string &key, Points &points)
{
    const auto &list = s.all(key);
    if (list.empty())
        return false;
    if (list.size() != 3 * kLegs)
        throw std::runtime_error(key + ": six points [x, y, z], or []");
    points = Eigen::Map<const Points>(list.data());
    return true;
}

/* Returns the mass centre in the platform's drawing. */
static Vec3 center(const Settings &s)
{
    return Vec3(s.at("payload.center_x_m"), s.at("payload.center_y_m"),
                -s.at("payload.center_height_m"));
}

Points upper_joints(const Settings &s)
{
    Points a;
    if (!drawn(s, "geometry.upper_joints_m", a))
        for (int i = 0; i < kLegs; i++) {
            const double angle =
                2 * kPi / 3 * (i / 2) + (i % 2 ? 1 : -1) * s.at("geometry.upper_half_angle_rad");
            const double r = s.at("geometry.upper_radius_m");
            a.col(i) << r * std::cos(angle), r * std::sin(angle), 0;
        }
    return a.colwise() - center(s);
}

Points lower_joints(const Settings &s)
{
    Points b;
    if (!drawn(s, "geometry.lower_joints_m", b)) {
        const double beta = s.at("geometry.lower_half_angle_rad");
        const double r = s.at("geometry.lower_radius_m");
        const double angle[kLegs] = {-kPi / 3 + beta, kPi / 3 - beta, kPi / 3 + beta,
                                     kPi - beta,      kPi + beta,     5 * kPi / 3 - beta};
        for (int i = 0; i < kLegs; i++)
            b.col(i) << r * std::cos(angle[i]), r * std::sin(angle[i]), 0;
    }
    b.row(2).array() += s.at("geometry.height_m");
    return b.colwise() - center(s);
}
