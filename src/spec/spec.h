/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What a user can ask for, as plain structs: the job and its parts.
 *
 * A job names a scenario, the scenario names its params' table and its defaults;
 * material, time, stop and record are the same for every scenario of a kind.
 * Everything is SI; angles are in degrees here (`_deg`) and in radians only
 * inside the physics. */
#ifndef SCREE_SPEC_SPEC_H
#define SCREE_SPEC_SPEC_H

#include "spec/field.h"

/* ---- material: glass-like spheres of seed 000 (law "hertz-mindlin-rolling") ---- */

/* What beads of that law may touch. Floors are of the beads' own matter. */
enum bead_partner { BEAD_BEAD, BEAD_WALL, BEAD_MIRROR };
struct material_wall { // a side wall of another matter (S4.4)
    int preset;
    double young_Pa, poisson; // E_w, nu_w
    double beta_s;            // beta_w, in place of beta
    double mu;                // mu_w, in place of mu_t
};
extern const struct field_table material_wall_table;
#define MATERIAL_PMMA                                                                                                              \
    {                                                                                                                              \
        .young_Pa = 3.3e9, .poisson = 0.4, .beta_s = 200e-9, .mu = 0.10510423526567647                                             \
    } // mu_w: tan 6 deg
extern const struct material_wall material_pmma;

struct material_spec {
    char preset[48];      // name of the published material that the other values start from
    double radius_m;      // median radius
    double radius_spread; // radii are uniform on radius * [1 - spread, 1 + spread]
    double density_kg_m3;
    double young_Pa;       // E
    double poisson;        // nu
    double beta_s;         // ratio of viscosity to stiffness: normal, tangential, torsion (eqs 5, 10, 17)
    double mu_t;           // sliding friction (eq. 11); torsional friction is 3 pi mu_t / 16 (eq. 18)
    double kappa;          // rolling stiffness modulus (eq. 22)
    double beta_r_s;       // rolling damping (eq. 24)
    double mu_r;           // rolling friction (eq. 25)
    double torsion_factor; // k_n = factor * G * a^3 (eq. 14): 16/3 as printed, 8/3 for two like bodies in series
    struct material_wall wall;
};
extern const struct field_table material_table;

/* A kind of material: the struct that a law takes, by its table. Each struct
 * begins with `char preset[48]` and fits the union in struct job_spec. */
struct material_kind {
    const char *law; // its name
    const struct field_table *table;
};
extern const struct material_kind material_beads, material_walls, material_fragments, material_rigid;

/* A published material: its values and what a reader must know about them. */
struct material_preset {
    const char *name, *doc, *source, *note; // note: errata worth a warning, "" if none
    const struct material_kind *kind;       // NULL: material_beads
    struct material_spec values;            // of beads
    const void *others;                     // of another kind: its struct
};
const struct material_kind *material_preset_kind(const struct material_preset *preset);
const void *material_preset_values(const struct material_preset *preset); // the kind's struct
extern const struct material_preset material_presets[];
extern const size_t material_preset_count;
const struct material_preset *material_preset_find(const char *name);

double material_shear_modulus(const struct material_spec *m);    // G = E / 2(1 + nu), Pa
double material_torsion_friction(const struct material_spec *m); // mu_n = 3 pi mu_t / 16
double material_grain_mass(const struct material_spec *m);       // of the median grain, kg
/* Duration of an elastic head-on impact of two free median grains at relative
 * speed v: T0 tau (eq. 42 with both spheres free, targets S0-06), s. */
double material_contact_time(const struct material_spec *m, double speed);
/* The largest time step at which the stiffest motion of a contact of median
 * grains that meet at `speed` is still integrated stably, s: see material.c for
 * the bound and its derivation. */
double material_stable_step(const struct material_spec *m, double speed);
/* A modulus of bead and wall together (eq. 33); E / (1 - nu^2) of a bead's contact with such a partner (S4.4). */
double material_wall_mean(double bead, double wall);
double material_plane_modulus(const struct material_spec *m, int partner);
/* Beads that meet each other at 2 v just as these meet their side wall at v: for the two functions above. */
struct material_spec material_as_wall(const struct material_spec *m);

/* ---- material: angular fragments of seed 003 (law "hertz-mindlin-tsuji") ---- */

/* What a clast may touch: Table 2's columns. */
enum fragment_partner { FRAGMENT_CLAST, FRAGMENT_CHUTE, FRAGMENT_GATE, FRAGMENT_PARTNERS };
struct fragment_matter { // Table 1
    double shear_Pa;     // G
    double poisson;      // nu
};
struct fragment_pair { // Table 2
    double restitution;
    double friction; // static, mu_s
    double rolling;  // mu_r of eq. 13
};
struct fragment_spec {
    char preset[48];
    double density_kg_m3; // of the clasts
    struct fragment_matter clast, chute, gate;
    struct fragment_pair clast_clast, clast_chute, clast_gate;
    double softening; // moduli are divided by it in every contact
    bool clamp;       // normal forces never pull (as published they do, at the end of a contact)
};
extern const struct field_table fragment_table;
extern const struct fragment_spec fragment_igneous; // Tables 1 and 2

const struct fragment_matter *fragment_matter_of(const struct fragment_spec *m, int partner);
const struct fragment_pair *fragment_pair_of(const struct fragment_spec *m, int partner);
double fragment_young_modulus(const struct fragment_matter *m); // E = 2 G (1 + nu), Pa
/* Time that a Rayleigh wave takes around a clast's sphere, softening included
 * (targets S3-15): pi R sqrt(rho / G) / (0.1631 nu + 0.8766), s. Time steps are
 * a share of it. */
double fragment_rayleigh_time(const struct fragment_spec *m, double radius_m);

/* ---- material: rigid convex bodies and composites of seed 001 (law "spring-dashpot-memory") ---- */

struct rigid_spec {
    char preset[48];
    double density_kg_m3;
    double stiffness;         // k_n, N/m
    double restitution;       // e_n of a head-on impact without eq. 5's clamp
    double stiffness_t;       // k_t, N/m
    double rate_t;            // gamma_t = eta_t / 2 m_ij, 1/s
    double friction, at_wall; // mu_c between bodies, and between a body and a wall
    double rolling;           // mu_r of A5-A9 between bodies
    double rolling_wall;      // and between a body and a wall
    double crust_m;           // thickness of the shell in which bodies touch
    bool average;             // forces between two bodies: mean over their points of contact; false: sum
    bool clamp;               // normal forces never pull (eq. 5, which the published code has not)
    bool memory;              // contacts remember k_t delta_t and k_r delta theta (eqs 6, A2); false: dashpots alone resist
};
extern const struct field_table rigid_table;
extern const struct rigid_spec rigid_crosses, rigid_beads; // Tables I and II

/* Duration of a head-on contact of reduced mass m_ij, kg (eq. 12), s. */
double rigid_contact_time(const struct rigid_spec *m, double reduced_mass);

enum body_shape { BODY_CROSS, BODY_BOX, BODY_TETRAPOD, BODY_SPHERE, BODY_PRISM, BODY_CYLINDER, BODY_HULLS, BODY_SPHERES };
enum { BODY_POINTS_TEXT = 1800, BODY_POINTS_MAX = 160, BODY_PARTS_MAX = 16 };
struct body_spec {
    int shape;
    double length_m, width_m, thickness_m; // of a cross' arms, a box; length_m: of a prism, a cylinder
    double radius_m;                       // of a sphere, a prism, a cylinder, or a tetrapod's legs, which are length_m long
    int64_t sides;                         // of a prism
    char points_m[BODY_POINTS_TEXT];       // of hulls and spheres
};
extern const struct field_table body_table;

double body_reach(const struct body_spec *body);  // from the centre to the farthest point, m
double body_volume(const struct body_spec *body); // for what a job costs: a tetrapod's is its legs', counted singly, m3

/* What the crust must leave a core of, m; infinite where only the scenario knows, or where no core is needed. */
double body_thinnest(const struct body_spec *body);
/* No narrower gap lets it through, m; 0: that is not known. */
double body_gap(const struct body_spec *body);

struct job_spec;
/* Refuses steps too long for contacts between bodies of that mass, kg. */
enum scree_status rigid_step_check(const struct job_spec *job, double mass, struct scree_error *err);

/* `points_m` as numbers: parts one after the other, part k from first[k] on; a sphere's radius is [3], m. */
struct body_points {
    size_t parts, count, first[BODY_PARTS_MAX + 1];
    double point[BODY_POINTS_MAX][4];
};
enum scree_status body_points(const struct body_spec *body, struct body_points *out, struct scree_error *err);

/* ---- time, stop, record ---- */

struct time_spec {
    double step_s, end_s;
};
enum stop_when {
    STOP_REST = 1 << 0,
    STOP_STEADY = 1 << 1,
    STOP_ACCELERATING = 1 << 2,
    STOP_ANY = STOP_REST | STOP_STEADY | STOP_ACCELERATING
};
struct stop_spec {
    unsigned when; // bits of enum stop_when; 0 runs to time.end_s
};
struct record_every { // a switch: one kind of record and how often it is taken
    bool on;
    double every_s;
};
struct record_series { // a switch: a dense series, cut into chunks of `chunk` samples
    bool on;
    double every_s;
    int64_t chunk;
};
struct record_views { // pictures
    bool on;
    double every_s;
    int64_t pixels; // across the sphere of a body's volume
};
struct record_profiles { // profiles along the base's normal
    bool on;
    double every_s; // between samples
    double frame_s; // that a frame is the mean of
};
struct record_log { // a record an event, `chunk` of them a chunk
    bool on;
    int64_t chunk;
    double from_s; // of the stream: millions of events before it are only counted
};
struct record_spectrum { // of the blocks of basal_force
    bool on;
    double window_s;
    int64_t segments; // half-overlapping ones a window
    double band_hz;   // width of the bands that are averaged over
    double fit_from_hz, fit_to_hz;
};
struct record_spec {
    struct record_series basal_force; // three components, block-averaged over every_s
    struct record_every bulk;         // kinetic and elastic energy, centre of mass, speeds: what verdicts rest on
    struct record_every energy;       // ledger: gravity's work, kinetic, elastic, dissipated
    struct record_every snapshots;    // every grain's state
    struct record_every flow;         // scenario chute: where the flow is, its agitation and losses
    struct record_every surface;      // continuum: free surface and static line along x
    struct record_every heap;         // rigid bodies: speeds, contacts, fabric, kind of collapse
    struct record_views views;        // rigid bodies: pictures from above and from aside
    struct record_every contact;      // scenario collision: overlap and forces of the one contact
    struct record_every rolling;      // scenario rolling: place, velocity and spin of the sphere
    struct record_profiles profiles;  // by height: phi, u, T, impacts, share joined to the base
    struct record_log collisions;     // every contact that forms
    struct record_every connectivity; // grains that chains of contacts join to the base
    struct record_spectrum spectrum;  // of the force on the base
    struct record_every forces;       // the network of contacts
};

/* ---- the job ---- */

enum { SPEC_PARAMS_MAX = 2816 };

/* What the paper says, to be printed beside what came out. "{restitution}" in it stands for that number of a job's
 * summary, "{answer}" for what a search found. */
enum { SPEC_PAPER_MAX = 384 };
#define SPEC_PAPER_DOC                                                                                                             \
    "what the paper says, printed beside the result: \"published 0.97, here {restitution}\", where {...} is a number of the "      \
    "summary, or a search's {answer}"

/* What a world takes in memory, bytes a grain, lists and histories at rest included (measured: src/dem/README.md). */
#define SPEC_BYTES_PER_GRAIN 1000.0
/* Grains in one world: rows are numbered in 25 bits. */
enum { SPEC_GRAINS_MAX = 30000000 };

struct job_spec {
    const struct scenario_fields *scenario; // never NULL once decoded
    int64_t seed;
    char title[128];
    char paper[SPEC_PAPER_MAX];
    int64_t threads;
    int64_t priority;
    _Alignas(16) unsigned char params[SPEC_PARAMS_MAX]; // the scenario's own struct
    union {                                             // by the scenario's kind of material
        struct material_spec material;                  // beads
        struct fragment_spec fragments;                 // fragments
        struct rigid_spec rigid;                        // rigid bodies
    };
    struct time_spec time;
    struct stop_spec stop;
    struct record_spec record;
};

/* Rows of the job but `scenario`, `params` and `material.preset`, which need
 * more than a table: protocol/job_json.c takes them. */
extern const struct field_table job_table;

enum scenario_kind { SCENARIO_DEM, SCENARIO_MPM, SCENARIO_CALCULATION };

/* A named set-up as the user sees it. What it does is in src/scenario/. */
struct scenario_fields {
    const char *name, *doc, *source;
    enum scenario_kind kind;
    const char *material;             // default preset; its kind is the scenario's
    const struct field_table *params; // its struct fits SPEC_PARAMS_MAX
    /* Overwrites those of the job's defaults that differ for this scenario. */
    void (*defaults)(struct job_spec *job);
    /* A row of params, a FIELD_ENUM, that names a published run, and what overwrites the job's values by that run's before
     * any other key is read. NULL: none. */
    const char *adopt_key;
    void (*adopt)(struct job_spec *job);
    /* Checks what ranges cannot say (time step against stiffness, intervals
     * against the step); the job has passed the range checks. */
    enum scree_status (*check)(const struct job_spec *job, struct scree_error *err);
    /* Size of the job: grains (moving and fixed), steps to end_s, bytes in memory. */
    struct job_cost (*cost)(const struct job_spec *job);
};
struct job_cost {
    double moving, fixed; // grains
    double steps;
    double bytes;
    double rate; // grain-steps a second of one core that estimates of time assume; set by job_cost
};
struct job_cost job_cost(const struct job_spec *job);
double job_cost_seconds(const struct job_cost *cost);
extern const struct scenario_fields *const scenario_list[];
extern const size_t scenario_count;
const struct scenario_fields *scenario_find(const char *name);
/* The kind of material that a scenario takes, and a job's table of it. */
const struct material_kind *scenario_material(const struct scenario_fields *scenario);

/* ---- params of each scenario ---- */

struct incline_params { // seed 000: steady flow down a rough slope, periodic in x; in y, too, or in scenario channel between sides
    double slope_deg;
    double gravity_m_s2;
    int64_t nx, ny, nz; // in grain diameters; nx * ny * nz grains flow
    int64_t base_seed;  // of the fixed base's realisation
};

enum collision_partner {
    PARTNER_SPHERE,
    PARTNER_FIXED_SPHERE,
    PARTNER_PLANE,
    PARTNER_WALL,
    PARTNER_MIRROR
};                        // planes from PLANE on
struct collision_params { // one contact: grain 1 meets a sphere or a plane along z
    int partner;
    double speed_m_s;            // closing speed along the normal
    double gap_m;                // at the start; 0 touches without overlap
    double radius1_m, radius2_m; // 0 takes the material's radius
    double tangential_m_s[3];    // of grain 1, relative, in the plane of contact (its z must be 0)
    double spin1_rad_s[3], spin2_rad_s[3];
    double gravity_m_s2[3];
};

enum { ROLLING_SAMPLES_MAX = 1 << 20 };
struct rolling_params { // a sphere on a plane that may be tilted
    double slope_deg;
    double gravity_m_s2;
    double speed_m_s; // down the slope at the start, without slip
    double length_m;  // of the plane
};

enum damping_length { DAMPING_FREE, DAMPING_PUBLISHED, DAMPING_PRINTED };
struct damping_params { // a calculation: beta from a restitution
    double restitution, speed_m_s;
    int length;
};

struct plastic_yield_params { // a calculation: the yield threshold from a restitution
    double restitution, speed_m_s;
    double at_m_s;
};

enum contact_partner { CONTACT_LIKE, CONTACT_WALL };
struct contact_parameters_params { // a calculation: what the linear spring and dashpot takes
    int partner;
    double mass_kg, radius_m, inertia_kg_m2; // 0: a sphere's
    double overlap_m, speed_m_s;
    double stiffness; // 0: from overlap and speed, N/m
    double restitution, restitution_t, rolling_friction, steps_per_contact;
};

/* What grain 1 meets, as an enum bead_partner. */
int collision_kind(const struct job_spec *job);

enum gas_box { GAS_PERIODIC, GAS_WALLED };
struct gas_params { // grains that fly about in a cube without gravity
    int64_t n;      // grains along each edge
    double solid_fraction, temperature_m2_s2;
    int box;
};
/* Edge of the cube, m. */
double gas_edge(const struct job_spec *job);

enum continuum_law { LAW_CONSTANT, LAW_MU_I, LAW_HYSTERETIC, LAW_HYSTERETIC_STEP };
/* The granular continuum and how it is solved: the same for every scenario of seed 002. */
struct continuum_spec {
    double density_kg_m3; // of the material where it is densest
    double grain_m;       // diameter, in the inertial number
    int law;
    double mu;                      // friction coefficient: the law's only one, mu(I)'s mu_stop, the hysteretic one in flow
    double mu_2, inertial0;         // of mu(I)
    double delta_mu, inertial_star; // of the hysteretic laws
    double inertial_fraction;       // I uses density / this: 0.6 the grains' (published code), 1 the bulk's (paper)
    int64_t points;                 // material points along a cell's edge
    double jitter;
    double tolerance; // of the mean squared residual
    int64_t sweeps;   // at most, a step
    double recover_s;
};
extern const struct field_table continuum_table;

struct collapse_params { // seed 002, section 4: a column on an erodible bed behind a gate
    int run;
    double slope_deg;
    double gravity_m_s2;
    double height_m, length_m, width_m; // of the column
    double bed_m, box_length_m, box_height_m;
    bool plane;
    double cell_m, cell_height_m;
    int64_t cells_across; // 0: as cell_m says
    double mu_wall, mu_gate, gate_speed_m_s, gate_tau_s, gate_wait_s;
    struct continuum_spec continuum;
};

struct tilt_params { // seed 002, section 2.4: a bed in a box that is tilted step by step
    double from_deg, to_deg, step_deg, hold_s;
    double gravity_m_s2;
    double length_m, height_m, width_m, bed_m;
    bool plane;
    int64_t cells_x, cells_y, cells_z;
    struct continuum_spec continuum;
};

struct layer_params { // an endless layer on a slope, as a continuum
    double slope_deg;
    double gravity_m_s2;
    double depth_m;
    int64_t cells; // through the depth
    struct continuum_spec continuum;
};

/* A clast of the user's own: what touches, and what it weighs by a closed convex polyhedron of triangles or in numbers. */
enum { CLAST_SPHERES = 32, CLAST_VERTICES = 16, CLAST_FACES = 2 * CLAST_VERTICES - 4 };
struct clast_spec {
    bool on;
    struct {
        int64_t count;
        double row[CLAST_SPHERES][4]; // x, y, z, radius, m
    } spheres;
    struct {
        int64_t count;
        double row[CLAST_VERTICES][3]; // m
    } vertices;
    struct {
        int64_t count;
        double row[CLAST_FACES][3]; // numbers of vertices
    } faces;
    double mass_kg, centre_m[3], moments_kg_m2[3], products_kg_m2[3]; // without faces
};

/* A wall of the user's own: what it is called by is what it is, so that a spec says all. The bytes are where meshes are kept. */
enum { MESH_NAME_MAX = 65, MESH_FILE_MAX = 128 };
struct mesh_spec {
    bool on;
    char sha256[MESH_NAME_MAX]; // of the file's bytes, 64 hexadecimal digits
    char file[MESH_FILE_MAX];   // where a client read it
    double unit_m;              // of the file's lengths
    bool closed;                // it must enclose a space
};

enum chute_accelerator { ACCELERATOR_CHUTE, ACCELERATOR_GATE };
struct chute_params { // seed 003: angular fragments down a curved chute
    double mass_g, size_m;
    double cubes, halves;       // shares of the mass; the rest are quarters
    int64_t spheres;            // along a cube's edge: 2 or 4
    double corners;             // radius of a sphere in each corner over the size; 0: none
    double space_mass_g;        // that the space behind the gate is made for; 0: mass_g
    double space_density_kg_m3; // of such a filling
    int accelerator;            // whose matter it has
    double gate_m_s;            // speed at which the gate slides off; 0: it vanishes at the start
    double gravity_m_s2;
    double floor_m, width_m, side_deg, guard_m, run_m, gate_m, flatness; // geometry; flatness in sizes
    struct clast_spec clast;
    struct mesh_spec mesh; // in place of the chute that the geometry makes
};

struct settle_params { // seed 001: bodies poured into a box come to rest
    double gravity_m_s2;
    int64_t count;
    double length_m, width_m; // of the box, which is open above
    struct body_spec body;
};

struct dam_break_params { // seed 001, III: a column of bodies behind a gate that goes
    double gravity_m_s2;
    int64_t count;
    double length_m, width_m; // of the box
    double column_m;          // length of the column: where the gate stands
    double settle_s;          // when the gate goes
    double gate_m_s2;         // its acceleration upwards; 0: it vanishes
    double gate_m_s;          // speed that it does not exceed
    struct body_spec body;
};

struct hopper_params { // seed 001, B.2: a hopper that empties onto a floor
    double gravity_m_s2;
    int64_t count;
    double floor_m;  // side of the square that pictures show
    double side_m;   // of the hopper
    double hole_m;   // side of the hole in its bottom
    double height_m; // of its bottom
    double settle_s; // when the hole opens
    struct body_spec body;
};

/* Fills a job with the defaults of a scenario and its preset material. */
void job_defaults(struct job_spec *job, const struct scenario_fields *scenario);

/* Every check that needs no simulation: ranges of all tables, then the
 * scenario's own. `memory_limit` in bytes (0: none). */
enum scree_status job_check(const struct job_spec *job, double memory_limit, struct scree_error *err);

/* One kind of record by its key under `record`, as the job asks for it. */
struct record_choice {
    bool on;
    double every_s;   // interval; 0: it has none
    const void *spec; // its struct in the job, which begins with the switch
};
struct record_choice record_find(const struct job_spec *job, const char *name);

/* A job that has begun may go on as `to` only where the tables say `steerable`
 * (or aside): SCREE_INVALID names the first other difference. */
enum scree_status job_steer_check(const struct job_spec *from, const struct job_spec *to, struct scree_error *err);

/* True when two jobs compute the same bits: they differ at most in what is aside. */
bool job_same(const struct job_spec *a, const struct job_spec *b);

#endif
