/* A remark that the writer of a configuration puts behind a key's value, such as the value's
 * interval (config_text_noted() in src/io/config.h). */
#ifndef HEXID_CONFIG_NOTE_H
#define HEXID_CONFIG_NOTE_H

enum { CONFIG_NOTE_KEY = 80, CONFIG_NOTE_SIZE = 120 };

struct config_note {
    char key[CONFIG_NOTE_KEY]; /* "payload.mass_kg" */
    char text[CONFIG_NOTE_SIZE];
};

#endif
