module bw_effect_table
  !! The table of effects that a scene may have or lack: their names, the groups or the number that switch them, and the values
  !! with which an effect is tried if the scene lacks it. `beamwave effects` runs each row with and without its effect,
  !! `describe` lists them. A second table holds the corrections that `beamwave identify` tries on a model that does not
  !! explain its lines.
  !!
  !! The table of groups says whether a group is an effect or an event, whether modes have a closed form, and what it needs.
  use bw_damping_par, only: usual_ratio
  use bw_input_name, only: name_length
  use bw_kinds, only: dp
  use bw_text, only: replaced
  implicit none (type, external)
  private
  public :: effect_number, in_words

  integer, parameter, public :: plain = 1, own_unit = 2, of_first_speed = 3, of_sphere = 4, of_duration = 5, of_section = 6, &
                              of_sphere_radius = 7
    !! units of the number with which an effect is tried: dimensionless; its unit formed from the beam's length, mass and time;
    !! the speed at which mode 1 becomes unstable; inertia and radius of a sphere of the beam's density; the duration of
    !! the response; the usual shear coefficient of the section

  type, public :: effect_type
    !! One effect. In texts `@` stands for the number with which it is tried.
    character(21) :: name = ''                    !! in results; reports write its underscores as blanks
    character(name_length) :: groups = ''         !! groups that switch it, separated by blanks
    character(name_length) :: input = ''          !! name that switches it; '': the presence of the groups does
    character(8) :: on = '', off = ''             !! values of this name with the effect and without it
    character(40) :: values = ''                  !! of the first group, if the scene lacks it; '': all defaults
    real(dp) :: tried = 0.0_dp                    !! number with which it is tried
    integer :: measure = plain                    !! unit of this number
    character(32) :: needs = '', excludes = ''    !! groups that a comparison needs or excludes, separated by blanks
    logical :: alone = .false.                    !! compared without the groups that need its group
    logical :: counted = .false.                  !! if present, compared only in scenes that count their modes
    character(96) :: remark_off = '', remark_on = ''   !! what is tried if the scene lacks it; how it is compared if not
    character(56) :: beside = 'the scene without it'   !! what it is compared with
  end type effect_type

  character(*), parameter :: both = 'rotation and stiffening, compared with neither'

  type(effect_type), parameter, public :: effect_table(*) = [ &
    effect_type('rotation', 'rotation', values='angular_velocity = @', tried=0.4_dp, measure=of_first_speed, alone=.true., &
                remark_off='tried in plane at @ rad/s', remark_on='without tension', beside='no rotation (both without tension)'), &
    effect_type('rotation_with_tension', 'rotation stiffening', values='angular_velocity = @', tried=0.4_dp, &
                measure=of_first_speed, remark_off=both//'; the tension is that of a hub without radius', remark_on=both, &
                beside='neither rotation nor tension'), &
    effect_type('out_of_plane', 'rotation', 'plane', "'out'", "'in'", needs='rotation', &
                remark_off='the rotation out of plane, compared with in plane', &
                remark_on='the rotation out of plane, compared with in plane', beside='the same rotation in plane'), &
    effect_type('stiffening', 'stiffening', needs='rotation', remark_off='tried with hub_radius = 0'), &
    effect_type('shear', 'shear', values='shear_coefficient = @', tried=1.0_dp, measure=of_section, &
                remark_off='tried with poisson_ratio = 0.3 and shear_coefficient = @'), &
    effect_type('damping', 'damping', values='ratio = @', tried=usual_ratio, remark_off='tried with ratio = @'), &
    effect_type('body_inertia', 'capture', 'rotary_inertia', '@', '0', tried=1.0_dp, measure=of_sphere, needs='capture', &
                remark_off='tried with rotary_inertia = @ kg m2, a solid sphere of the beam''s density', &
                beside='a point mass'), &
    effect_type('capture', 'capture', needs='impact', counted=.true., &
                remark_on='compared with a rebound with as many modes as before the capture', beside='a rebound'), &
    effect_type('release', 'release', values='time = @', tried=0.5_dp, measure=of_duration, needs='capture response', &
                remark_off='tried at half of the duration'), &
    effect_type('recontact', 'recontact', needs='impact response', excludes='capture force base'), &
    effect_type('contact', 'contact', values='radius = @', tried=1.0_dp, measure=of_sphere_radius, &
                needs='impact response', excludes='recontact', counted=.true., &
                remark_off='tried with a sphere of @ m, the mass in the beam''s density', &
                remark_on='compared with an instantaneous blow', &
                beside='an instantaneous blow'), &
    effect_type('force', 'force', values='amplitude = @', tried=1.0e-3_dp, measure=own_unit, needs='impact response', &
                excludes='recontact', &
                remark_off='tried with a half sine of @ N, 0.001 EI/l^2, over the record', &
                beside='the scene without any force'), &
    effect_type('base', 'base', values='amplitude = @', tried=1.0e-3_dp, measure=own_unit, needs='impact response', &
                excludes='recontact', &
                remark_off='tried with a half sine of @ m/s2 over the record, 0.001 EI/(m l^2)', &
                beside='the scene without any acceleration of the base'), &
    effect_type('initial', 'initial', values='force = @', tried=0.01_dp, measure=own_unit, needs='impact response', &
                excludes='recontact', counted=.true., &
                remark_off='tried with force = @ N at the tip, EI/l^2/100', &
                remark_on='compared with a straight beam at rest', &
                beside='a beam at rest'), &
    effect_type('pieces', 'beam', 'length', tried=0.9_dp, &
                remark_off='tried with an outer half whose youngs_modulus is @ of that of the inner one', &
                remark_on='compared with a uniform beam of the same length, mass and mean E I', &
                beside='a uniform beam of its mass and mean E I'), &
    effect_type('taper', 'beam', 'taper', tried=0.9_dp, remark_off='tried with a tip section of @ times that of the root', &
                remark_on='compared with a uniform beam of the same length, mass and mean E I', &
                beside='a uniform beam of its mass and mean E I'), &
    effect_type('support', 'support', values='rotational_stiffness = @', tried=100.0_dp, measure=own_unit, &
                remark_off='tried with rotational_stiffness = @ N m/rad, 100 EI/l', beside='a clamped root'), &
    effect_type('tip_support', 'tip_support', values='stiffness = @, rotational_stiffness = 0', tried=1.0_dp, measure=own_unit, &
                remark_off='tried with stiffness = @ N/m, EI/l^3, and rotational_stiffness = 0', &
                beside='a free tip'), &
    effect_type('hub', 'hub', values='rotary_inertia = @', tried=1.0_dp, measure=own_unit, &
                remark_off='tried with rotary_inertia = @ kg m2, the beam''s mass times l^2', &
                beside='a hub whose motion is prescribed'), &
    effect_type('body', 'body', values='position = 0.5, mass_ratio = @', tried=0.01_dp, &
                remark_off='tried with a mass of @ of the beam''s at the midpoint', beside='the scene without any body'), &
    effect_type('position', 'impact', 'position', '@', '1', tried=0.9_dp, needs='impact', &
                remark_off='a blow at xi = @, compared with one at the tip', remark_on='compared with a blow at the tip', &
                beside='a blow at the tip')]

  integer, parameter, public :: added = 1, given = 2, toggled = 3
    !! `added`: a group or a name is added; `given`: a given value is changed; `toggled`: the effect of the row is switched

  type, public :: correction_type
    !! A possible error of a model of a beam: an effect that it lacks, or a wrong number.
    character(40) :: words = ''
    character(name_length) :: group = ''          !! group of the scene, or effect that is toggled
    integer :: kind = added
    character(36) :: unknown = ''                 !! numbers of the group to be fitted, at most two, separated by blanks
    real(dp) :: first(2) = 0.0_dp, last(2) = 0.0_dp    !! their ranges, in units of the beam's length, mass and time
    real(dp) :: factor = 0.0_dp                   !! if not 0: the range is the given value divided and multiplied by this
    character(16) :: values = ''                  !! further values that are set
    logical :: neutral_at_last = .false.          !! an addition has no effect at the end of its range; else at its start
  end type correction_type

  type(correction_type), parameter, public :: correction_table(*) = [ &
    correction_type('shear and rotary inertia', 'shear'), &
    correction_type('a root that turns', 'support', unknown='rotational_stiffness', first=0.1_dp, last=1.0e5_dp, &
                    neutral_at_last=.true.), &
    correction_type('a root that deflects', 'support', unknown='stiffness', first=1.0_dp, last=1.0e7_dp, &
                    neutral_at_last=.true.), &
    correction_type('a mass at the tip', 'body', unknown='mass', last=1.0_dp, values='position = 1'), &
    correction_type('a mass on the beam', 'body', unknown='mass position', first=[0.0_dp, 0.02_dp], last=1.0_dp), &
    correction_type('tension by rotation', 'stiffening'), &
    correction_type('rotation in the other plane', 'out_of_plane', toggled), &
    correction_type('another rotational stiffness of the root', 'support', given, 'rotational_stiffness', factor=1.0e4_dp), &
    correction_type('another stiffness of the root', 'support', given, 'stiffness', factor=1.0e4_dp), &
    correction_type('another speed', 'rotation', given, 'angular_velocity', factor=3.0_dp), &
    correction_type('another mass of the first body', 'body', given, 'mass', factor=30.0_dp), &
    correction_type('another place of the first body', 'body', given, 'position', first=0.02_dp, last=1.0_dp), &
    correction_type('a body''s rotary inertia', 'body', given, 'rotary_inertia', last=0.1_dp), &
    correction_type('another modulus', 'beam', given, 'youngs_modulus', factor=3.0_dp)]

contains

  pure integer function effect_number(name)
    !! Return the place of an effect in `effect_table`; 0 for an unknown one.
    character(*), intent(in) :: name
    effect_number = findloc(effect_table%name == name, .true., dim=1)
  end function effect_number

  pure function in_words(name) result(words)
    !! Return the name of an effect in words.
    character(*), intent(in) :: name
    character(:), allocatable :: words
    words = replaced(trim(name), '_', ' ')
  end function in_words

end module bw_effect_table
