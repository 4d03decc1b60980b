// Two materials in a plate with a clamped side, a seam between the materials and a named corner.
SetFactory("OpenCASCADE");
Rectangle(1) = {0, 0, 0, 1, 1};
Rectangle(2) = {1, 0, 0, 1, 1};
Coherence;
MeshSize{ PointsOf{ Surface{:}; } } = 0.4;
Physical Surface("soft") = {1};
Physical Surface("hard") = {2};
Physical Curve("left") = {4};
Physical Curve("seam") = {2};
Physical Curve("ground", 40) = {1, 5};
Physical Point("corner") = {1};
