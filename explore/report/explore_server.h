// The page of `explore` over HTTP, for this machine alone.
#pragma once

#include "analysis/explore/explore.h"

#include <functional>

namespace explore::report {

// Listens on this port (0: any that is free) of 127.0.0.1 and no other interface until the program is interrupted, and
// answers requests
//     GET /            the page
//     GET /state       what the page shows first
//     GET /evaluate    ?at=V,V,...           a point; with &changed=I:V,I:V,... readings I (from 0) taken to be V
//     GET /fit         ?at=...               the minimum that a search from there ends in
//     GET /landscape   ?at=...&x=K&y=K&lines=N&fitted=0|1
//     GET /confirm     ?at=...               the point by the full model
// with JSON (report/explore.h) if they carry the token (&token=...), name 127.0.0.1:PORT or localhost:PORT as their
// host and, where they have an Origin, come from a page of this server; the others with 403 and no more. Bad
// parameters: 400 and {"error"}. ready: called with the address of the page, token included, once it is reachable.
// Throws pave::Error for a port that is taken.
void serve_explorer(analysis::Explorer& explorer, int port,
                    const std::function<void(const std::string& address)>& ready);

} // namespace explore::report
