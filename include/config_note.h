/* A remark that is written behind a key's value in a configuration file, such as the interval of
 * the value (config_text_noted() in src/io/config.h). */
#ifndef HEXID_CONFIG_NOTE_H
#define HEXID_CONFIG_NOTE_H

enum { CONFIG_NOTE_KEY = 80, CONFIG_NOTE_SIZE = 120 };

struct config_note {
    char key[CONFIG_NOTE_KEY]; /* "payload.mass_kg" */
    char text[CONFIG_NOTE_SIZE];
};

#endif
