// The ledger: the energy that bodies took in and lost.
#pragma once

namespace rockslip {

/// What was taken in and lost since the start, J.
struct Ledger {
    double input = 0;      // work of the moving ground
    double friction = 0;
    double damping = 0;    // of the platform's dashpot; of dashpots, flow and fracture of links
    double contact = 0;    // impacts and the velocity level
    double numerical = 0;  // time stepping of the platform

    /// Books what the impulses of a contact, or of several, took: friction's share and the rest.
    void book(double lost, double rubbed) {
        friction += rubbed;
        contact += lost - rubbed;
    }
};

}  // namespace rockslip
