/* SPDX-License-Identifier: GPL-3.0-or-later */
/* `scree materials`: the published materials, with what a reader must know about them. */
#include <stdio.h>

#include "describe.h"
#include "protocol/job_json.h"
#include "table.h"
#include "verbs.h"

static void print_list(void)
{
    static const char *const headers[] = {"material", "what it is", "source", NULL};
    struct table table;
    table_start(&table, headers);
    for (size_t k = 0; k < material_preset_count; k++) {
        const char *const cells[] = {material_presets[k].name, material_presets[k].doc, material_presets[k].source};
        table_row(&table, cells, COLOUR_NONE);
    }
    table_end(&table, 0);
    for (size_t k = 0; k < material_preset_count; k++)
        if (*material_presets[k].note) {
            printf("\n%s:\n", material_presets[k].name);
            describe_paragraph(material_presets[k].note, 2, 100);
        }
    printf("\n`scree materials NAME` shows the values.\n");
}

static void print_one(const struct material_preset *preset)
{
    printf("%s%s%s: %s\nsource: %s\n", colour_on(stdout, COLOUR_BOLD), preset->name, colour_off(stdout, COLOUR_BOLD), preset->doc,
           preset->source);
    if (*preset->note) {
        printf("note:\n");
        describe_paragraph(preset->note, 2, 100);
    }
    printf("\nfields (a job's \"material\" takes the preset and overrides single values)\n");
    describe_fields(material_preset_kind(preset)->table, material_preset_values(preset), "");
    if (material_preset_kind(preset) != &material_beads)
        return;
    printf("\nwhat follows\n"
           "  shear modulus                     %.4g Pa\n"
           "  torsional friction                %.4g\n"
           "  mass of the median grain          %.4g kg\n"
           "  elastic impact at 0.14 m/s lasts  %.4g s\n",
           material_shear_modulus(&preset->values), material_torsion_friction(&preset->values),
           material_grain_mass(&preset->values), material_contact_time(&preset->values, 0.14));
}

static enum outcome not_found(const char *name)
{
    struct scree_error err;
    const char *words[65], *near;
    size_t count = 0;
    for (; count < material_preset_count && count < 64; count++)
        words[count] = material_presets[count].name;
    words[count] = NULL;
    near = word_nearest(words, name);
    outcome_fail(&err, OUTCOME_REFUSED, "there is no material \"%.60s\"%s%s%s", name, near ? "; did you mean \"" : "",
                 near ? near : "", near ? "\"?" : "");
    scree_hint(&err, "`scree materials` lists them");
    return give_up(OUTCOME_REFUSED, &err);
}

static void print_json(const struct material_preset *preset)
{
    cJSON *json = material_describe(preset);
    if (json)
        put_json_line(json);
    cJSON_Delete(json);
}

static enum outcome materials_run(const struct arguments *arguments)
{
    if (arguments->word_count == 0) {
        if (!arguments->json)
            print_list();
        for (size_t k = 0; arguments->json && k < material_preset_count; k++)
            print_json(&material_presets[k]);
        return OUTCOME_DONE;
    }
    const struct material_preset *preset = material_preset_find(arguments->words[0]);
    if (!preset)
        return not_found(arguments->words[0]);
    if (arguments->json)
        print_json(preset);
    else
        print_one(preset);
    return OUTCOME_DONE;
}

const struct verb verb_materials = {
    .name = "materials",
    .synopsis = "[NAME]",
    .doc = "the published materials; with NAME their values",
    .help = "Needs no daemon. With --json one object a material.\n"
            "\n"
            "  scree materials\n"
            "  scree materials glass-beads-2mm\n",
    .words_max = 1,
    .run = materials_run,
};
