module bw_beam_par
  !! `&beam`: a beam of uniform pieces, one or several, from the root outwards.
  use bw_input_name, only: input_group, input_name, positive, reals_input
  use bw_input_values, only: group_values
  use bw_kinds, only: dp, qp
  use bw_missing, only: is_missing, missing
  use bw_scene_messages, only: message_list, round_product
  use bw_text, only: shortest, text_of
  implicit none (type, external)
  private
  public :: area_of, beam_mass, beam_text, build_beam, check_beam, piece_mass, pieces_of_beam, &
    second_moment_of

  type, public :: beam_piece
    !! A piece of one material and one section.
    real(dp) :: length = 0.0_dp          !! l_i [m], > 0
    real(dp) :: density = 0.0_dp         !! ρ [kg/m³], > 0
    real(dp) :: youngs_modulus = 0.0_dp  !! E [Pa], > 0
    real(dp) :: diameter = missing       !! D of a solid circle [m]; `missing` where the section was given otherwise
    real(dp) :: area = 0.0_dp            !! A [m²], given, or πD²/4, or w h
    real(dp) :: second_moment = 0.0_dp   !! I [m⁴], given, or πD⁴/64, or w h³/12
    logical :: round = .false.           !! the diameter was given
    real(dp) :: width = missing          !! w of a solid rectangle [m]; `missing` where the section was given otherwise
    real(dp) :: height = missing         !! h of a solid rectangle [m], along which it bends; as the width
  end type beam_piece

  type, extends(beam_piece), public :: beam_par
    !! The whole beam. Its length is that of all pieces together; what else it has as a piece is that of the piece at the root.
    type(beam_piece), allocatable :: pieces(:)   !! from the root outwards, at least 2; unallocated: the beam is uniform, (n)
  end type beam_par

  type(input_group), parameter, public :: beam_group = input_group( &
    'beam', required=.true., unless='record', absent='an error, unless a `&record` is analysed for frequencies alone', &
    rules='Give `diameter` for a solid circle, `width` and `height` for a solid rectangle, which bends along its height, or '// &
    '`area` and `second_moment` for any other section. `length` says how many uniform pieces the beam has, from the root '// &
    'outwards, as `length = 0.3, 0.7`; every other name has one value for all pieces, or one for each. A sweep varies one '// &
    'value of a list by its number, as `beam%length(2)`.')

  integer, parameter :: most_pieces = 1000

  type(input_name), parameter, public :: beam_names(*) = [ &
    input_name('beam', 'length', reals_input, 'm', positive, required=.true., swept=.true., most=most_pieces, along='piece', &
               meaning='length from the root to the tip, or of each piece'), &
    input_name('beam', 'density', reals_input, 'kg m-3', positive, required=.true., swept=.true., most=most_pieces, &
               along='piece', meaning='mass density of the material'), &
    input_name('beam', 'youngs_modulus', reals_input, 'Pa', positive, required=.true., swept=.true., most=most_pieces, &
               along='piece', meaning='Young''s modulus E'), &
    input_name('beam', 'diameter', reals_input, 'm', positive, swept=.true., most=most_pieces, along='piece', &
               excludes='width height area second_moment', meaning='diameter of a solid circular section'), &
    input_name('beam', 'width', reals_input, 'm', positive, swept=.true., most=most_pieces, along='piece', &
               excludes='diameter area second_moment', meaning='width of a solid rectangular section'), &
    input_name('beam', 'height', reals_input, 'm', positive, swept=.true., most=most_pieces, along='piece', &
               excludes='diameter area second_moment', meaning='height of a solid rectangular section, along which it bends'), &
    input_name('beam', 'area', reals_input, 'm2', positive, swept=.true., most=most_pieces, along='piece', &
               excludes='diameter width height', meaning='area of the section'), &
    input_name('beam', 'second_moment', reals_input, 'm4', positive, swept=.true., most=most_pieces, along='piece', &
               excludes='diameter width height', meaning='second moment of area I of the section, bending stiffness E I')]

  character(*), parameter :: sections = 'diameter, or width and height, or area and second_moment'
  real(qp), parameter :: pi = 3.14159265358979323846264338327950288_qp

contains

  pure subroutine check_beam(beam, messages)
    !! A section is needed, and lists go together.
    type(group_values), intent(in) :: beam
    type(message_list), intent(inout) :: messages
    call check_section(beam, messages)
    call check_counts(beam, messages)
  end subroutine check_beam

  pure subroutine check_section(beam, messages)
    !! A diameter, or the two names of another section together.
    type(group_values), intent(in) :: beam
    type(message_list), intent(inout) :: messages
    if (beam%given('diameter')) return
    if (beam%given('width') .or. beam%given('height')) then
      call check_pair(beam, 'width', 'height', messages)
    else if (beam%given('area') .or. beam%given('second_moment')) then
      call check_pair(beam, 'area', 'second_moment', messages)
    else
      call messages%add(0, 'beam%diameter', 'is missing; accepted: '//sections)
    end if
  end subroutine check_section

  pure subroutine check_pair(beam, one, other, messages)
    !! Neither of two names stands alone.
    type(group_values), intent(in) :: beam
    character(*), intent(in) :: one, other
    type(message_list), intent(inout) :: messages
    character(:), allocatable :: absent
    if (beam%given(one) .and. beam%given(other)) return
    absent = one
    if (beam%given(one)) absent = other
    call messages%add(0, 'beam%'//absent, 'is missing; accepted: '//one//' and '//other//', or diameter alone')
  end subroutine check_pair

  pure subroutine check_counts(beam, messages)
    !! `length` says how many pieces there are; another name has one value for all of them, or one for each.
    type(group_values), intent(in) :: beam
    type(message_list), intent(inout) :: messages
    character(:), allocatable :: hint
    integer :: v, n, pieces
    pieces = beam%count_of('length')
    do v = 1, size(beam%values)
      associate (value => beam%values(v))
        n = beam%count_of(value%name)
        if (pieces == 0 .or. n < 2 .or. n == pieces) cycle
        hint = ''
        if (all(value%numbers == value%numbers(1))) hint = ' (in a namelist '//text_of(n)//'*'//shortest(value%numbers(1), 15)// &
          ' is the value '//text_of(n)//' times, and no product)'
        call messages%add(value%line, 'beam%'//trim(value%name), 'has '//text_of(n)//' values'//hint//', and length has '// &
                          text_of(pieces)//', which says how many pieces there are; accepted: one value'// &
                          repeat(', or one for each piece', merge(1, 0, pieces > 1)))
      end associate
    end do
  end subroutine check_counts

  pure subroutine build_beam(values, beam, messages)
    !! From checked values; what is not given follows from what is.
    type(group_values), intent(in) :: values
    type(beam_par), intent(out) :: beam
    type(message_list), intent(inout) :: messages
    integer :: count, i
    count = values%count_of('length')
    call build_piece(values, 1, beam%beam_piece, messages)
    if (count == 1) return
    allocate (beam%pieces(count))
    beam%pieces(1) = beam%beam_piece
    do i = 2, count
      call build_piece(values, i, beam%pieces(i), messages)
    end do
    call round_product(sum(real(beam%pieces%length, qp)), beam%length, values%line_of('length'), 'beam%length', &
                        'the length of all pieces', messages)
  end subroutine build_beam

  pure subroutine build_piece(values, i, piece, messages)
    !! Piece i, from checked values.
    type(group_values), intent(in) :: values
    integer, intent(in) :: i
    type(beam_piece), intent(out) :: piece
    type(message_list), intent(inout) :: messages
    character(:), allocatable :: name, a, b
    piece%length = values%number_at('length', i)
    piece%density = values%number_at('density', i)
    piece%youngs_modulus = values%number_at('youngs_modulus', i)
    piece%round = values%given('diameter')
    if (piece%round) then
      piece%diameter = values%number_at('diameter', i)
      name = 'diameter'
      a = 'pi/4 D^2'
      b = 'pi/64 D^4'
    else if (values%given('width')) then
      piece%width = values%number_at('width', i)
      piece%height = values%number_at('height', i)
      name = 'height'
      a = 'w h'
      b = 'w h^3/12'
    else
      piece%area = values%number_at('area', i)
      piece%second_moment = values%number_at('second_moment', i)
      return
    end if
    call round_product(area_of(piece), piece%area, values%line_of(name), 'beam%'//name, 'the area '//a, messages)
    call round_product(second_moment_of(piece), piece%second_moment, values%line_of(name), 'beam%'//name, &
                        'the second moment of area '//b, messages)
  end subroutine build_piece

  elemental real(qp) function area_of(piece) result(area)
    !! A [m²] in extended precision, from what was given.
    type(beam_piece), intent(in) :: piece
    area = piece%area
    if (piece%round) area = pi/4*real(piece%diameter, qp)**2
    if (.not. is_missing(piece%width)) area = real(piece%width, qp)*piece%height
  end function area_of

  elemental real(qp) function second_moment_of(piece) result(second_moment)
    !! I [m⁴] in extended precision, from what was given.
    type(beam_piece), intent(in) :: piece
    second_moment = piece%second_moment
    if (piece%round) second_moment = pi/64*real(piece%diameter, qp)**4
    if (.not. is_missing(piece%width)) second_moment = piece%width*real(piece%height, qp)**3/12
  end function second_moment_of

  elemental real(qp) function piece_mass(piece)
    !! ρAl [kg], in extended precision from what was given: no product of doubles overflows there.
    type(beam_piece), intent(in) :: piece
    piece_mass = real(piece%density, qp)*area_of(piece)*piece%length
  end function piece_mass

  elemental real(qp) function beam_mass(beam)
    !! m_i [kg], the mass of all pieces together.
    type(beam_par), intent(in) :: beam
    if (allocated(beam%pieces)) then
      beam_mass = sum(piece_mass(beam%pieces))
    else
      beam_mass = piece_mass(beam%beam_piece)
    end if
  end function beam_mass

  pure function pieces_of_beam(beam) result(pieces)
    !! All pieces, one of a uniform beam.
    type(beam_par), intent(in) :: beam
    type(beam_piece), allocatable :: pieces(:)
    if (allocated(beam%pieces)) then
      pieces = beam%pieces
    else
      pieces = [beam%beam_piece]
    end if
  end function pieces_of_beam

  pure function beam_text(beam) result(text)
    !! Of what a report says of it the part that a uniform beam has not: ` in 2 pieces (0.3, 0.7 m)`, or nothing.
    type(beam_par), intent(in) :: beam
    character(:), allocatable :: text
    integer, parameter :: most = 5
    integer :: i
    text = ''
    if (.not. allocated(beam%pieces)) return
    text = ' in '//text_of(size(beam%pieces))//' pieces'
    if (size(beam%pieces) > most) return
    text = text//' ('
    do i = 1, size(beam%pieces)
      if (i > 1) text = text//', '
      text = text//shortest(beam%pieces(i)%length, 6)
    end do
    text = text//' m)'
  end function beam_text

end module bw_beam_par
