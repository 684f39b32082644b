//! Picture tests: scenes drawn without a window, on whatever Vulkan driver there is, and looked at pixel by pixel.
//!
//! First what can be counted in a picture, then what must equal a reference that knows no mirrors.

mod support;

mod pictures {
    mod atmosphere;
    mod bad_input;
    mod behind;
    mod billboards;
    mod bounces;
    mod cameras;
    mod changes;
    mod churn;
    mod company;
    mod contents;
    mod continuity;
    mod cover;
    mod cutting;
    mod effects;
    mod extremes;
    mod figures;
    mod foreign;
    mod hard_cases;
    mod harness;
    mod holes;
    mod idle;
    mod indirect;
    mod leftovers;
    mod lighting;
    mod looks;
    mod materials;
    mod objects;
    mod precision;
    mod projections;
    mod random_scenes;
    mod required;
    mod seams;
    mod settings;
    mod several;
    mod shadows;
    mod shapes;
    mod start;
    mod surfaces;
    mod targets;
    mod transmission;
    mod unbounded;
    mod views;
}
